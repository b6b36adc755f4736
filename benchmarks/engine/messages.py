"""Round-trip time of messages between robots of a map, by the placement of their containers.

Each clone sends its pose to its own robot and to the clones of the map's other robots, as it does while robots drive.
The bench measures the delay until the other robot receives the pose. The links to the two robots are alike, so the
difference is the route between the containers: machine link, fabric, machine link. Both directions are added.
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from typing import ClassVar

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.driving_robot import grid_to_drive_on
from benchmarks.engine.options import EngineOptions
from benchmarks.engine.site import EngineSite
from benchmarks.engine.talking_robot import TalkingRobot, talking_robot
from benchmarks.harness.figures import Figure, median_and_p99, median_of
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped
from ppaas.nodes.base import Node, Payload, Topic
from ppaas.nodes.graph import Graph
from robots.sim.courses import CoursePlanner

PING, PONG = Topic("ping", PoseWithCovarianceStamped), Topic("pong", PoseWithCovarianceStamped)

MESSAGE = PoseWithCovarianceStamped(Header(frame_id="map"), PoseWithCovariance(Pose.of(Pose2D(1.0, 2.0, 0.5))))


class PongNode(Node):
    """Publishes each message that it receives."""

    name: ClassVar[str] = "answerer"
    subscribes: ClassVar[tuple[Topic, ...]] = (PING,)
    publishes: ClassVar[tuple[Topic, ...]] = (PONG,)

    def on_message(self, topic: str, message: Payload) -> None:
        """Publish the message."""
        self.context.publish(PONG.name, message)


class PingNode(Node):
    """Publishes a message, and records the time of the answer.

    Attributes
    ----------
    answered : float
        Time of the last answer [monotonic s].
    """

    name: ClassVar[str] = "asker"
    subscribes: ClassVar[tuple[Topic, ...]] = (PONG,)
    publishes: ClassVar[tuple[Topic, ...]] = (PING,)
    answered: float = 0.0

    def on_message(self, topic: str, message: Payload) -> None:
        """Record the time of the answer."""
        self.answered = monotonic()

    def ask(self) -> float:
        """Publish a message; return the time until its answer [s]."""
        began = monotonic()
        self.context.publish(PING.name, MESSAGE)
        return self.answered - began


def in_one_container(rounds: int) -> list[float]:
    """Return the round-trip times of a pose between two nodes of a graph [s]."""
    graph = Graph()
    graph.add(PongNode)
    asker = graph.add(PingNode)
    return [asker.ask() for _ in range(rounds)]


PART = "messages"
ROUNDS, QUICK = 100, 5
PERIOD = 0.25
"""Period of the messages of a robot [s]; a container does not publish to others more often."""

ACQUAINTED = 30.0
"""Time limit of the warm-up, until both robots have received a message [s]."""


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Measure between two nodes of a container, two containers of a machine, and containers of two machines."""
    grid, rounds = grid_to_drive_on(), options.of(ROUNDS, QUICK)
    within = in_one_container(options.of(1000, 100))
    async with _pair(site, "near", grid, site.machine) as robots:
        near = await _round_trips(robots, rounds, "containers of one machine", progress)
    async with site.second_machine() as second, _pair(site, "far", grid, second.name) as robots:
        far = await _round_trips(robots, rounds, "containers of two machines", progress)
    echoes = await baselines.echoes(options.of(1000, 100))
    return [
        *median_and_p99(PART, "in a container", within, note="two nodes of a graph, called in this process"),
        *median_and_p99(PART, "between containers of a machine", near, note=f"{options.runtime}; a pose and back"),
        *median_and_p99(
            PART, "between two machines", far, note=f"{options.runtime}; two agents on this host, over mutual TLS"
        ),
        median_of(PART, "a byte to a process and back", echoes, yardstick=True, note="by a Unix socket, no loop"),
    ]


@contextlib.asynccontextmanager
async def _pair(
    site: EngineSite, name: str, grid: GridMap, machine: str
) -> AsyncIterator[tuple[TalkingRobot, TalkingRobot]]:
    """Open two robots on a new map: the first on the cloud's local machine, the second on ``machine``."""
    map_id = f"bench-{name}"
    await site.target.publish(map_id, grid)
    first, second = CoursePlanner(grid, 1).choose(2, 1)
    async with contextlib.AsyncExitStack() as stack:
        async with site.only_on(site.machine):
            speaker = talking_robot(site.target, f"{map_id}-1", map_id, grid, first.start)
            one = await stack.enter_async_context(speaker)
        async with site.only_on(machine):
            speaker = talking_robot(site.target, f"{map_id}-2", map_id, grid, second.start)
            other = await stack.enter_async_context(speaker)
        yield one, other


async def _round_trips(
    robots: tuple[TalkingRobot, TalkingRobot], rounds: int, description: str, progress: Progress
) -> list[float]:
    """Exchange messages in turns; return the times of round trips without a lost message [s]."""
    one, other = robots
    await _get_acquainted(one, other, description)
    trips: list[float | None] = []
    for _ in progress.track(range(rounds), description=description):
        trips.append(await _round_trip(one, other))
    heard = [trip for trip in trips if trip is not None]
    if not heard:
        raise Unavailable(f"{description}: all {rounds} round trips lost a message")
    return heard


async def _get_acquainted(one: TalkingRobot, other: TalkingRobot, description: str) -> None:
    """Exchange messages until both robots received one, as a warm-up."""
    until = monotonic() + ACQUAINTED
    while await _round_trip(one, other) is None:
        if monotonic() > until:
            raise Unavailable(f"{description}: no message arrived within {ACQUAINTED:g} s: see the log of the cloud")


async def _round_trip(one: TalkingRobot, other: TalkingRobot) -> float | None:
    began = monotonic()
    there, back = await _one_way(one, other), await _one_way(other, one)
    await asyncio.sleep(max(PERIOD - (monotonic() - began), 0.0))
    return None if there is None or back is None else there + back


async def _one_way(speaker: TalkingRobot, listener: TalkingRobot) -> float | None:
    said, x = await speaker.say()
    heard = await listener.others.of(x)
    return None if heard is None else heard - said
