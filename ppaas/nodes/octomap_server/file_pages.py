"""Pages of an OctoMap file, which clients get one after the other."""

import base64

from ppaas.errors import InvalidInput
from ppaas.messages.octomap_msgs import GetOctomapFileResponse
from ppaas.nodes.grid_slam.posegraph_pages import PAGE


class FilePages:
    """Serves a file page by page, and forgets it after its end.

    Parameters
    ----------
    file : bytes
    """

    def __init__(self, file: bytes) -> None:
        self._file = file

    def page(self, offset: int) -> GetOctomapFileResponse:
        """Return the page at an offset [bytes].

        Raises
        ------
        InvalidInput
            The offset is beyond the end of the file.
        """
        size = len(self._file)
        if not 0 <= offset <= size:
            raise InvalidInput(f"the file of the octomap has {size} bytes, not {offset}: begin at 0")
        page = self._file[offset : offset + PAGE]
        if offset == size:
            self._file = b""
        return GetOctomapFileResponse(base64.b64encode(page).decode(), size)
