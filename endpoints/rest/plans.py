"""Paths: asked for and looked up again."""

import uuid
from typing import Any

import msgspec
import numpy as np
from fastapi import APIRouter
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.kept_plans import visible_plan
from endpoints.rest.names import MapId, PlanId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.schemas import NewPlanAnswer, PlanAnswer, PlanFile, triple
from endpoints.rest.strict_json import StrictRoute
from endpoints.settings import Settings
from engine.model import MapVersion
from engine.views import PathAnswer, PathRequest
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter
from storage.records import MapRecord, PlanRecord, User

router = APIRouter(tags=["plans"], route_class=StrictRoute)


@router.post(
    "/maps/{map_id}/plans",
    status_code=201,
    response_model=NewPlanAnswer,
    responses=KNOWN | BODY | problems(404, 409, 429),
)
async def make_plan(map_id: MapId, file: PlanFile, services: Provided, user: Caller) -> Response:
    """Plan a path on a map, and keep it."""
    head = await readable_head(services, user, map_id)
    request = PathRequest(
        start=triple(file.start),
        goal=triple(file.goal),
        planner=file.planner,
        tolerance=file.tolerance,
        timeout=_timeout(file, services.settings),
    )
    answer = await services.cloud.compute_path(user, MapVersion(head.id, head.version), request)
    record = _record(user, head, request, answer)
    await services.plan_keeper.keep(services.store, record)
    found = {"expanded": answer.expanded, "container": answer.container, "pid": answer.pid}
    return _json(_path(record) | found, status=201)


@router.get("/plans/{plan_id}", response_model=PlanAnswer, responses=KNOWN | problems(404))
async def show_plan(plan_id: PlanId, services: Provided, user: Caller) -> Response:
    """Return a path that was kept: one's own, or one on a map that one may see."""
    record = await visible_plan(services, user, plan_id)
    asked = {name: getattr(record, name) for name in ("user", "robot", "start", "goal", "created")}
    return _json(_path(record) | asked)


def _timeout(file: PlanFile, settings: Settings) -> float:
    if file.timeout is None:
        return settings.default_plan_seconds
    if file.timeout > settings.max_plan_seconds:
        raise InvalidParameter(f"timeout: a planner is given {settings.max_plan_seconds:g} s at most")
    return file.timeout


def _record(user: User, head: MapRecord, request: PathRequest, answer: PathAnswer) -> PlanRecord:
    return PlanRecord(
        id=uuid.uuid4().hex,
        user=user.id,
        map=head.id,
        version=head.version,
        planner=answer.planner,
        start=request.start,
        goal=request.goal,
        length=answer.length,
        cost=answer.cost,
        seconds=answer.seconds,
        poses=answer.poses,
        created=epoch(),
    )


def _path(record: PlanRecord) -> dict[str, Any]:
    return {
        "plan_id": record.id,
        "poses": np.frombuffer(record.poses, dtype="<f8").reshape(-1, 7).tolist(),
        "length": record.length,
        "cost": record.cost,
        "seconds": record.seconds,
        "planner": record.planner,
        "map": record.map,
        "version": record.version,
    }


def _json(answer: dict[str, Any], status: int = 200) -> Response:
    """Serialise once and without checking each of thousands of numbers, as FastAPI would."""
    return Response(msgspec.json.encode(answer), status, media_type="application/json")
