"""Opens robots by their WebSockets, and has their clones answer."""

from dataclasses import dataclass

import msgspec
from websockets.asyncio.client import ClientConnection

from ppaas.errors import Unavailable
from ppaas.maps.generate import warehouse
from robots.bench.plan_requests import compute_path_call, ends
from robots.bench.target import Target

MAP = "bench-engine"


@dataclass(frozen=True, slots=True)
class Question:
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
            There is none.
        """
        await socket.send(self.frame)
        while (answer := _read(await socket.recv())).op != "service_response":
            continue
        if not answer.result:
            raise Unavailable(f"a clone has no path: {bytes(answer.values).decode()}")


class _Answer(msgspec.Struct):
    op: str
    result: bool = False
    values: msgspec.Raw = msgspec.Raw()


def _read(frame: str | bytes) -> _Answer:
    return msgspec.json.decode(frame, type=_Answer)


async def prepared(target: Target) -> Question:
    """Publish the map of the bench; return what can be asked on it."""
    grid = warehouse(seed=1)
    start, goal = ends(grid)
    await target.publish(MAP, grid)
    return Question(start, compute_path_call(start, goal))
