"""Paths that were kept: looked up again."""

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
    """Return a path that was kept: one's own, or one on a map that one may see."""
    record = await visible_plan(services, user, plan_id)
    asked = {name: getattr(record, name) for name in ("user", "robot", "start", "goal", "created")}
    return json_response(path_of(record) | asked)


def path_of(record: PlanRecord) -> dict[str, Any]:
    """Return what is told of every path."""
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


def json_response(answer: dict[str, Any]) -> Response:
    """Serialise once and without checking each of thousands of numbers, as FastAPI would."""
    return Response(msgspec.json.encode(answer), media_type="application/json")
