"""The cells of a map, for who draws it: what its files mean, whatever format and thresholds they have."""

import gzip
from typing import Any

from fastapi import APIRouter, Request
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.services import Services
from ppaas.maps.files import load_map

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
    cells = await run_in_threadpool(_cells, services, map_id, packed=packed)
    headers = {"X-Content-Type-Options": "nosniff", "Vary": "Accept-Encoding"}
    return Response(
        cells, media_type="application/octet-stream", headers=headers | ({"Content-Encoding": "gzip"} if packed else {})
    )


def _cells(services: Services, map_id: str, *, packed: bool) -> bytes:
    record = services.map_store.map(map_id)
    cells = load_map(record.yaml, record.image).data.tobytes()
    return gzip.compress(cells, _FASTEST) if packed else cells
