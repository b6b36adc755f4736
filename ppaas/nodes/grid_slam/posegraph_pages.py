"""Pages of a pose graph: its file is made in a job when the first page is requested, and kept for the others."""

from collections.abc import Callable
from functools import partial

from ppaas.errors import PPaaSError
from ppaas.mapping.serialization.mapping import Mapping
from ppaas.mapping.serialization.mapping_file import pack_mapping
from ppaas.messages.slam_toolbox import GetPoseGraphResponse
from ppaas.nodes.base import Context, Reply
from ppaas.nodes.file_pages import FilePages
from ppaas.nodes.jobs import LongWork


class PosegraphPages:
    """Serves the file of a mapping page by page.

    Parameters
    ----------
    context : Context
        Of the node.
    """

    def __init__(self, context: Context) -> None:
        self._context = context
        self._pages = FilePages("pose graph")

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
        else:
            reply(self._page(numbers, offset))

    def forget(self) -> None:
        """Forget the file."""
        self._pages.forget()

    def _first(self, numbers: GetPoseGraphResponse, reply: Reply, file: bytes | PPaaSError) -> None:
        if isinstance(file, PPaaSError):
            reply(file)
            return
        self._pages.use(file)
        reply(self._page(numbers, 0))

    def _page(self, numbers: GetPoseGraphResponse, offset: int) -> GetPoseGraphResponse:
        numbers.data, numbers.size = self._pages.page(offset)
        return numbers
