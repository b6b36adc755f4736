"""Start of containers: time from opening a robot's WebSocket to the first message and the first path."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass

import msgspec
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from benchmarks.engine import baselines
from benchmarks.engine.options import PAUSES, READY_LIMIT_MS, EngineOptions
from benchmarks.engine.site import EngineSite
from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_and_p99
from benchmarks.harness.plan_calls import compute_path_call, ends
from ppaas.clock import monotonic
from ppaas.decoding import from_json
from ppaas.errors import Unavailable
from ppaas.maps.generate import warehouse

MAP = "bench-engine"

OPEN_TIMEOUT = 120.0
"""Time limit of a connection [s]: long, for many at once or a runtime without containers in reserve."""


@dataclass(frozen=True, slots=True)
class FirstPathQuestion:
    """A path request to a clone: its answer is the first that is useful to a robot.

    Parameters
    ----------
    start : tuple of float
        Pose of the robot: x, y [m], yaw [rad].
    frame : str
        WebSocket frame of the request.
    """

    start: tuple[float, float, float]
    frame: str

    async def ask(self, socket: ClientConnection) -> None:
        """Send the request and wait for the path.

        Raises
        ------
        Unavailable
            No path was computed, or the cloud closed the connection.
        """
        try:
            await socket.send(self.frame)
            while (answer := _read(await socket.recv())).op != "service_response":
                continue
        except WebSocketException as error:
            raise Unavailable(f"the cloud closed the connection of a robot that requested a path: {error}") from error
        if not answer.result:
            raise Unavailable(f"a clone computed no path: {bytes(answer.values).decode()}")


@contextlib.asynccontextmanager
async def opened(url: str) -> AsyncIterator[ClientConnection]:
    """Open a robot's WebSocket.

    Raises
    ------
    Unavailable
        The cloud refuses the connection.
    """
    try:
        socket = await connect(url, max_size=None, open_timeout=OPEN_TIMEOUT)
    except (OSError, WebSocketException) as error:
        raise Unavailable(f"the cloud refused the connection of a robot: {error}") from error
    async with socket:
        yield socket


class _Answer(msgspec.Struct):
    op: str
    result: bool = False
    values: msgspec.Raw = msgspec.Raw()


def _read(frame: str | bytes) -> _Answer:
    return from_json(frame, _Answer)


async def prepared(target: CloudUnderTest) -> FirstPathQuestion:
    """Publish the map of the bench; return a path request on it."""
    grid = warehouse(seed=1)
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    return FirstPathQuestion(start, compute_path_call(start, goal))


# -- start of a container ----------------------------------------------------------------------------------------------

PART = "ready"
OPENS, OPENS_WITH_PAUSES, QUICK = 100, 20, 3

FIRST_MESSAGE = '{"op":"subscribe","topic":"tf_static"}'
"""Subscription to a latched topic, which the clone answers at once."""


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Open robots in turns with empty Python processes; the first robot is a warm-up, as the map is new for it."""
    pause = PAUSES.get(options.runtime, 0.0)
    opens = options.of(OPENS_WITH_PAUSES if pause else OPENS, QUICK)
    question = await prepared(site.target)
    opened, started = [], []
    for number in progress.track(range(opens + 1), description="opening robots"):
        opened.append(await _open(site, f"bench-ready-{number}", question))
        started.append(await baselines.python())
        await asyncio.sleep(pause)
    ready, answered = zip(*opened[1:], strict=True)
    paced = f", one each {pause:g} s" if pause else ""
    limit, how = READY_LIMIT_MS[options.runtime], f"{options.runtime}{paced}; from opening the socket to"
    return [
        *median_and_p99(PART, "container ready", ready, limit=limit, note=f"{how} the clone's first message"),
        *median_and_p99(PART, "first path", answered, limit=limit, note=f"{how} a path by its planner"),
        *baselines.figures(PART, started, await baselines.forks(opens)),
    ]


async def _open(site: EngineSite, robot: str, question: FirstPathQuestion) -> tuple[float, float]:
    """Return the times until the first message and until the path [s]."""
    url = await site.target.register(robot, MAP, question.start)
    began = monotonic()
    async with opened(url) as socket:
        await socket.send(FIRST_MESSAGE)
        await socket.recv()
        heard = monotonic()
        await question.ask(socket)
        return heard - began, monotonic() - began
