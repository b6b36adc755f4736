"""Pages of a pose graph: its file is made in a job when the first page is requested, and kept for the others."""

import base64
from collections.abc import Callable
from functools import partial

from ppaas.errors import InvalidInput, PPaaSError
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.messages.slam_toolbox import GetPoseGraphResponse
from ppaas.nodes.base import Context, Reply
from ppaas.nodes.jobs import LongWork

PAGE = 3 << 18
"""Size of a page [bytes]; 1 MiB in base64."""


class PosegraphPages:
    """Serves the file of a mapping page by page.

    Parameters
    ----------
    context : Context
        Of the node.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._file = b""

    def make(self, mapping: Mapping, done: Callable[[bytes | PPaaSError], None]) -> None:
        """Make the file of a mapping in a job, and call back with it."""
        self._context.start(LongWork(lambda _cancelled: b"".join(pack_mapping(mapping))), done)

    def serve(self, mapping: Mapping, offset: int, numbers: GetPoseGraphResponse, reply: Reply) -> None:
        """Reply with a page.

        Parameters
        ----------
        mapping : Mapping
            Of which a new file is made for the first page.
        offset : int
            Offset in the file [bytes].
        numbers : GetPoseGraphResponse
            Response without the page.
        reply : callable

        Raises
        ------
        InvalidInput
            There is no file to continue, or the offset is beyond its end.
        """
        if offset == 0:
            self.make(mapping, partial(self._first, numbers, reply))
            return
        if not 0 < offset <= len(self._file):
            raise InvalidInput(f"the file of the pose graph has {len(self._file)} bytes, not {offset}: begin at 0")
        reply(self._page(numbers, offset))

    def forget(self) -> None:
        """Forget the file."""
        self._file = b""

    def _first(self, numbers: GetPoseGraphResponse, reply: Reply, file: bytes | PPaaSError) -> None:
        if isinstance(file, PPaaSError):
            reply(file)
            return
        self._file = file
        reply(self._page(numbers, 0))

    def _page(self, numbers: GetPoseGraphResponse, offset: int) -> GetPoseGraphResponse:
        page = self._file[offset : offset + PAGE]
        numbers.data, numbers.size = base64.b64encode(page).decode(), len(self._file)
        if offset + len(page) == len(self._file) and not page:
            self.forget()
        return numbers
