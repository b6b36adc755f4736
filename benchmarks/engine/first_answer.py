"""Opens robots by their WebSockets, and has their clones answer."""

import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass

import msgspec
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import WebSocketException

from benchmarks.harness.cloud_under_test import Target
from benchmarks.harness.plan_calls import compute_path_call, ends
from ppaas.errors import Unavailable
from ppaas.maps.generate import warehouse

MAP = "bench-engine"

OPEN_TIMEOUT = 120.0
"""Seconds: where many come at a time, or a runtime has nothing in reserve, the last waits long."""


@dataclass(frozen=True, slots=True)
class FirstPathQuestion:
    """A path that is asked for of a clone: the first answer of which a robot has any use.

    Parameters
    ----------
    start : tuple of float
        Where the robot stands: x, y [m], yaw [rad].
    frame : str
        The question.
    """

    start: tuple[float, float, float]
    frame: str

    async def ask(self, socket: ClientConnection) -> None:
        """Ask, and wait for the path.

        Raises
        ------
        Unavailable
            There is none, or the cloud hangs up.
        """
        try:
            await socket.send(self.frame)
            while (answer := _read(await socket.recv())).op != "service_response":
                continue
        except WebSocketException as error:
            raise Unavailable(f"a robot that asked was hung up on: {error}") from error
        if not answer.result:
            raise Unavailable(f"a clone has no path: {bytes(answer.values).decode()}")


@contextlib.asynccontextmanager
async def opened(url: str) -> AsyncIterator[ClientConnection]:
    """Open a robot's WebSocket.

    Raises
    ------
    Unavailable
        It is not let in.
    """
    try:
        socket = await connect(url, max_size=None, open_timeout=OPEN_TIMEOUT)
    except (OSError, WebSocketException) as error:
        raise Unavailable(f"a robot was not let in: {error}") from error
    async with socket:
        yield socket


class _Answer(msgspec.Struct):
    op: str
    result: bool = False
    values: msgspec.Raw = msgspec.Raw()


def _read(frame: str | bytes) -> _Answer:
    return msgspec.json.decode(frame, type=_Answer)


async def prepared(target: Target) -> FirstPathQuestion:
    """Publish the map of the bench; return what can be asked on it."""
    grid = warehouse(seed=1)
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    return FirstPathQuestion(start, compute_path_call(start, goal))
