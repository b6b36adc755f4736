"""Files that the clones of robots hand out and take page by page."""

import base64
from collections.abc import Awaitable, Callable

from endpoints.resources.heavy_work import HeavyWork
from engine.control.robot_nodes import RobotNodes
from ppaas.errors import Unavailable
from ppaas.messages.octomap_msgs import GetOctomapFileResponse
from ppaas.messages.slam_toolbox import GetPoseGraphResponse

MOST_BYTES = 1 << 28
"""Largest pose graph or octomap that is taken from a robot [bytes]."""

FilePage = GetPoseGraphResponse | GetOctomapFileResponse
"""Page of a file."""


async def whole_file(first: FilePage, page_at: Callable[[int], Awaitable[FilePage]], robot: str) -> bytes:
    """Return a file from its first page on.

    Parameters
    ----------
    first : FilePage
    page_at : callable
        Returns the page at an offset [bytes].
    robot : str
        Name of the robot, for errors.

    Raises
    ------
    Unavailable
        The file changed meanwhile, ended early or is too large, or a page is not base64.
    """
    page, file = first, bytearray()
    while data := _data_of(page, robot):
        file += data
        if page.size != first.size or len(file) > min(first.size, MOST_BYTES):
            raise Unavailable(f"the map of robot {robot!r} changed while it was read, or is too large: try again")
        page = await page_at(len(file))
    if len(file) != first.size:
        raise Unavailable(f"the map of robot {robot!r} ended early: try again")
    return bytes(file)


def _data_of(page: FilePage, robot: str) -> bytes:
    try:
        return base64.b64decode(page.data, validate=True)
    except ValueError as error:
        raise Unavailable(f"robot {robot!r} sent a part of its map that is not base64: {error}") from error


class PosegraphReader:
    """Reads the pose graphs of robots, each for one caller at once: a clone has the pages of its newest file only."""

    def __init__(self) -> None:
        self._turns = HeavyWork(of_user=1)

    async def fetch(self, nodes: RobotNodes, user: str, robot: str) -> tuple[bytes, GetPoseGraphResponse]:
        """Return the file of the map that a robot makes, as it was at the first page, and its numbers.

        Parameters
        ----------
        nodes : RobotNodes
        user, robot : str

        Raises
        ------
        Unavailable
            See `whole_file`; or the robot has no container or no map now.
        Conflict
            The robot does not make a map.
        """
        async with self._turns.turn_of_user(f"{user}/{robot}"):
            first = await nodes.map(user, robot, 0)
            return await whole_file(first, lambda offset: nodes.map(user, robot, offset), robot), first
