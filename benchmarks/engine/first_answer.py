"""Opens robots by their WebSockets, and requests a first path from their clones."""

import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass

import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from benchmarks.harness.cloud_under_test import Target
from benchmarks.harness.plan_calls import compute_path_call, ends
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


async def prepared(target: Target) -> FirstPathQuestion:
    """Publish the map of the bench; return a path request on it."""
    grid = warehouse(seed=1)
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    return FirstPathQuestion(start, compute_path_call(start, goal))
