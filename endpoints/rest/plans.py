"""Paths: asked for and looked up again."""

import uuid
from typing import Any

import numpy as np
from fastapi import APIRouter
from pydantic import BaseModel
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.schemas import NewPlanAnswer, PlanAnswer, PlanFile, triple
from endpoints.settings import Settings
from engine.model import MapVersion
from engine.views import PathAnswer, PathRequest
from ppaas.clock import epoch
from ppaas.errors import InvalidParameter, NotFound
from storage.records import MapRecord, PlanRecord, User

router = APIRouter(tags=["plans"])


@router.post("/maps/{map_id}/plans", status_code=201, response_model=NewPlanAnswer)
async def make_plan(map_id: str, file: PlanFile, services: Provided, user: Caller) -> Response:
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
    await run_in_threadpool(services.store.add_plan, record)
    return _json(
        NewPlanAnswer.model_construct(
            **_path(record), expanded=answer.expanded, container=answer.container, pid=answer.pid
        ),
        status=201,
    )


@router.get("/plans/{plan_id}", response_model=PlanAnswer)
async def show_plan(plan_id: str, services: Provided, user: Caller) -> Response:
    """Return a path that was kept: one's own, or one on a map that one may see."""
    record = await run_in_threadpool(services.store.plan, plan_id)
    if record.user != user.id:
        try:
            await readable_head(services, user, record.map)
        except NotFound as error:
            raise NotFound("plan", plan_id) from error
    return _json(
        PlanAnswer.model_construct(
            **_path(record),
            user=record.user,
            robot=record.robot,
            start=list(record.start),
            goal=list(record.goal),
            created=record.created,
        )
    )


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


def _json(answer: BaseModel, status: int = 200) -> Response:
    """Serialise once and without checking each of thousands of numbers, as FastAPI would."""
    return Response(answer.model_dump_json(), status, media_type="application/json")
