"""Route of cost matrices: costs of the cheapest paths from each of many starts to each of many goals."""

import msgspec
from fastapi import APIRouter
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.plans.planning import check_timeout
from endpoints.rest.plans.schemas import CostFile, CostMatrixAnswer
from endpoints.rest.strict_json import StrictRoute
from engine.service.planning.requests import CostRequest
from engine.specs.containers import MapVersion
from ppaas.decoding import converted

router = APIRouter(tags=["plans"], route_class=StrictRoute)


@router.post(
    "/maps/{map_id}/cost_matrix",
    response_model=CostMatrixAnswer,
    responses=KNOWN | BODY | problems(404, 409, 429),
)
async def compute_costs(map_id: MapId, file: CostFile, services: Provided, user: Caller) -> Response:
    """Return the cost of the cheapest path from each start to each goal; at most 50000 costs per request."""
    request = converted(file.model_dump(exclude_none=True), CostRequest)
    check_timeout(request.timeout, services.limits)
    await services.cloud.count_paths(user.id, max(len(request.starts), 1))
    head = await readable_head(services, user, map_id)
    answer = await services.cloud.planning.compute_costs(user.id, MapVersion(head.id, head.version), request)
    return Response(msgspec.json.encode(answer), media_type="application/json")
