"""The cells of a map, for who draws it: what its files mean, whatever format and thresholds they have."""

import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np
from fastapi import APIRouter, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response, StreamingResponse

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.services.services import Services
from ppaas.maps.formats.map_files import open_grid
from storage.versions import IMAGE, YAML

_GZIP = 31
"""What zlib calls the format of gzip, with its largest window."""

router = APIRouter(prefix="/maps", tags=["maps"])

_FASTEST = 1
"""Level of compression: cells are long runs of the same, which the fastest finds as well."""

_DESCRIBED: dict[int | str, dict[str, Any]] = {
    200: {
        "description": "`height` rows of `width` bytes, the lowest row first: 0 free to 100 occupied, 255 unknown",
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


@router.get("/{map_id}/cells", response_class=Response, responses=_DESCRIBED | KNOWN | problems(404))
async def fetch_cells(map_id: MapId, request: Request, services: Provided, user: Caller) -> Response:
    """Return the cells of a map, a byte each, as `nav_msgs/OccupancyGrid` orders them."""
    await readable_head(services, user, map_id)
    packed = "gzip" in request.headers.get("accept-encoding", "")
    cells = await run_in_threadpool(_cells, services, map_id)
    headers = {"X-Content-Type-Options": "nosniff", "Vary": "Accept-Encoding"}
    if packed:
        cells, headers = _packed(cells), headers | {"Content-Encoding": "gzip"}
    return StreamingResponse(cells, media_type="application/octet-stream", headers=headers)


def _cells(services: Services, map_id: str) -> Iterator[bytes]:
    """Return the cells, some rows at a time; what of the map can be wrong is told before the first."""
    with services.map_store.open_map(map_id, only=(YAML, IMAGE)) as opened:
        grid = open_grid(*opened.grid())
    return (np.ascontiguousarray(rows).data.cast("B").tobytes() for _, rows in grid.blocks())


def _packed(cells: Iterator[bytes]) -> Iterator[bytes]:
    packer = zlib.compressobj(_FASTEST, wbits=_GZIP)
    for block in cells:
        yield packer.compress(block)
    yield packer.flush()
