"""Files that the clones of robots hand out and take page by page."""

import base64
from collections.abc import Awaitable, Callable

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
        The file changed meanwhile, ended early or is too large.
    """
    page, file = first, bytearray()
    while data := base64.b64decode(page.data):
        file += data
        if page.size != first.size or len(file) > min(first.size, MOST_BYTES):
            raise Unavailable(f"the map of robot {robot!r} changed while it was read, or is too large: try again")
        page = await page_at(len(file))
    if len(file) != first.size:
        raise Unavailable(f"the map of robot {robot!r} ended early: try again")
    return bytes(file)
