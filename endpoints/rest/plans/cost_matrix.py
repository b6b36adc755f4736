"""What it costs to get from each of many starts to each of many goals."""

from fastapi import APIRouter
from msgspec import Raw
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.plans.planning import allowed_timeout
from endpoints.rest.plans.plans import json_response
from endpoints.rest.plans.schemas import CostFile, CostMatrixAnswer
from endpoints.rest.schemas import triple
from endpoints.rest.strict_json import StrictRoute
from engine.service.path_requests import CostRequest
from engine.specs.containers import MapVersion

router = APIRouter(tags=["plans"], route_class=StrictRoute)


@router.post(
    "/maps/{map_id}/cost_matrix",
    response_model=CostMatrixAnswer,
    responses=KNOWN | BODY | problems(404, 409, 429),
)
async def compute_costs(map_id: MapId, file: CostFile, services: Provided, user: Caller) -> Response:
    """Tell what the cheapest path costs from each start to each goal; at most 50000 costs at a time."""
    services.cloud.quotas.learn(user)
    services.cloud.plan_rate.take(user.id, max(len(file.starts), 1))
    head = await readable_head(services, user, map_id)
    request = CostRequest(
        starts=tuple(map(triple, file.starts)),
        goals=tuple(map(triple, file.goals)),
        timeout=allowed_timeout(file.timeout, services.settings),
        labels=file.labels,
    )
    answer = await services.cloud.compute_costs(user, MapVersion(head.id, head.version), request)
    told = {"costs": Raw(answer.costs), "seconds": answer.seconds, "map": head.id, "version": head.version}
    return json_response(told | {"container": answer.container, "pid": answer.pid})
