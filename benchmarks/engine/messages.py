"""How long a message takes from robot to robot of the same map, and back, by where their containers are.

Each robot's clone tells its own robot where that is, and the others of the map: as containers do while robots drive.
What is measured is how much later the other robot hears it. Both ways to the robots are alike, so what is left is the
way between the containers: machine link, fabric, machine link. There and back are added.
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.driving_robot import grid_to_drive_on
from benchmarks.engine.options import EngineOptions
from benchmarks.engine.ping_pong import in_one_container
from benchmarks.engine.samples import median_and_p99
from benchmarks.engine.site import EngineSite
from benchmarks.engine.talking_robot import TalkingRobot, talking_robot
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.maps.grid import GridMap
from robots.sim.courses import CoursePlanner

PART = "messages"
ROUNDS, QUICK = 100, 5
PERIOD = 0.25
"""Seconds between two messages of a robot: sooner, its container tells the others nothing new."""

ACQUAINTED = 30.0
"""Seconds within which both are heard before the first round that counts."""


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Let two nodes of a container, two containers of a machine, and those of two machines speak to each other."""
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
    """Open two robots on a map of their own: the first on the cloud's first machine, the second where it is said."""
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
    """Let both speak in turns; return the round trips of which no way was lost [s]."""
    one, other = robots
    await _get_acquainted(one, other, description)
    trips: list[float | None] = []
    for _ in progress.track(range(rounds), description=description):
        trips.append(await _round_trip(one, other))
    heard = [trip for trip in trips if trip is not None]
    if not heard:
        raise Unavailable(f"{description}: of {rounds} messages and their answers none was heard")
    return heard


async def _get_acquainted(one: TalkingRobot, other: TalkingRobot, description: str) -> None:
    """Let both speak until both were heard: what is kept ready for the first message is not measured."""
    until = monotonic() + ACQUAINTED
    while await _round_trip(one, other) is None:
        if monotonic() > until:
            raise Unavailable(f"{description}: not heard within {ACQUAINTED:g} s: see the log of the cloud")


async def _round_trip(one: TalkingRobot, other: TalkingRobot) -> float | None:
    began = monotonic()
    there, back = await _one_way(one, other), await _one_way(other, one)
    await asyncio.sleep(max(PERIOD - (monotonic() - began), 0.0))
    return None if there is None or back is None else there + back


async def _one_way(speaker: TalkingRobot, listener: TalkingRobot) -> float | None:
    said, x = await speaker.say()
    heard = await listener.others.of(x)
    return None if heard is None else heard - said
