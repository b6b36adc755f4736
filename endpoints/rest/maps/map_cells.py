"""Route of a map's cells, decoded from its files, for programs that draw the map."""

import zlib
from collections.abc import Iterator
from contextlib import AsyncExitStack
from typing import Annotated, Any

import numpy as np
from fastapi import APIRouter, Query, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response, StreamingResponse
from starlette.types import Receive, Scope, Send

from endpoints.resources.services import Services
from endpoints.rest.dependencies import AnyCaller, Provided, check_unscoped, readable_head
from endpoints.rest.names import MapId, Version
from endpoints.rest.openapi import KNOWN, problems
from ppaas.maps.formats.map_files import open_grid
from storage.versions import IMAGE, YAML

_GZIP = 31
"""``wbits`` of zlib for the gzip format with the largest window."""

router = APIRouter(prefix="/maps", tags=["maps"])

_FASTEST = 1
"""Compression level: the fastest compresses long runs of equal cells as well as any other."""

_DESCRIBED: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "`height` rows of `width` bytes, the lowest row first: 0 free to 100 occupied, 255 unknown",
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.get("/{map_id}/cells", response_class=Response, responses=_DESCRIBED | KNOWN | problems(404))
async def fetch_cells(
    map_id: MapId,
    request: Request,
    services: Provided,
    user: AnyCaller,
    version: Annotated[
        Version | None,
        Query(
            description="SHA-256 of the files of a version, also of one that waits for a review; default: the current"
        ),
    ] = None,
) -> Response:
    """Return the cells of a map, one byte each, in the order of `nav_msgs/OccupancyGrid`."""
    if version is not None:
        check_unscoped(user)
    await readable_head(services, user, map_id)
    turn = AsyncExitStack()
    await turn.enter_async_context(services.heavy_work.turn_of_user(user.id))
    try:
        cells = await run_in_threadpool(_cells, services, map_id, version)
        return CellsResponse(cells, turn, compressed="gzip" in request.headers.get("accept-encoding", ""))
    except BaseException:
        await turn.aclose()
        raise


class CellsResponse(StreamingResponse):
    """Response with the cells of a map. It ends a turn when it has been sent: until then it holds the decoded image.

    Parameters
    ----------
    cells : iterator of bytes
        Blocks of rows.
    turn : AsyncExitStack
        Ends the turn.
    compressed : bool
        Whether to send gzip.
    """

    def __init__(self, cells: Iterator[bytes], turn: AsyncExitStack, *, compressed: bool) -> None:
        headers = {"X-Content-Type-Options": "nosniff", "Vary": "Accept-Encoding"}
        if compressed:
            cells, headers = _compress(cells), headers | {"Content-Encoding": "gzip"}
        super().__init__(cells, media_type="application/octet-stream", headers=headers)
        self._turn = turn

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Send the response, then end the turn."""
        async with self._turn:
            await super().__call__(scope, receive, send)


def _cells(services: Services, map_id: str, version: str | None) -> Iterator[bytes]:
    """Return the cells in blocks of rows; errors of the map are raised before the first block."""
    with services.map_store.open_map(map_id, version, only=(YAML, IMAGE)) as opened:
        grid = open_grid(*opened.grid())
    return (np.ascontiguousarray(rows).data.cast("B").tobytes() for _, rows in grid.blocks())


def _compress(cells: Iterator[bytes]) -> Iterator[bytes]:
    compressor = zlib.compressobj(_FASTEST, wbits=_GZIP)
    for block in cells:
        yield compressor.compress(block)
    yield compressor.flush()
