"""Route of a stored path by its id."""

from typing import Any

import msgspec
from fastapi import APIRouter
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.names import PlanId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.plans.schemas import PlanAnswer
from endpoints.rest.plans.stored_plans import visible_plan
from endpoints.rest.strict_json import StrictRoute
from storage.plan_checks import array_of
from storage.records import PlanRecord

router = APIRouter(tags=["plans"], route_class=StrictRoute)


@router.get("/plans/{plan_id}", response_model=PlanAnswer, responses=KNOWN | problems(404))
async def show_plan(plan_id: PlanId, services: Provided, user: Caller) -> Response:
    """Return a stored path: your own, or one on a map that you may read."""
    record = await visible_plan(services, user, plan_id)
    request = {name: getattr(record, name) for name in ("user", "robot", "start", "goal", "created")}
    # Encoded here: FastAPI would validate each of thousands of numbers.
    return Response(msgspec.json.encode(path_of(record) | request), media_type="application/json")


def path_of(record: PlanRecord) -> dict[str, Any]:
    """Return the fields that every response with a path has."""
    return {
        "plan_id": record.id,
        "poses": array_of(record.poses).tolist(),
        "length": record.length,
        "cost": record.cost,
        "seconds": record.seconds,
        "planner": record.planner,
        "map": record.map,
        "version": record.version,
    }
