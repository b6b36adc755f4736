"""Routes of the Path Plan Database: search by start and goal, replace, change; shared segments and statistics."""

from typing import Annotated, Any

import msgspec
import numpy as np
from fastapi import APIRouter, Body, Query, Response
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.user_lookup import find_user
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Caller, Provided, readable_head
from endpoints.rest.names import MapId, PlanId
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.plans.schemas import (
    FoundPlans,
    Parts,
    PlanChange,
    PlanPut,
    PlanSearch,
    PlanSummary,
    StatisticsAnswer,
    place_of,
)
from endpoints.rest.plans.stored_plans import check_may_change, summary_of, visible_plan
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute, merge
from endpoints.sharing.shared_robots import is_author, plans_shown
from ppaas.clock import epoch
from ppaas.errors import NotFound
from ppaas.geometry import yaw_of
from ppaas.plans.passages import length_between
from storage import plan_query
from storage.plan_checks import array_of
from storage.records import PlanPart, PlanRecord, PlanStatistics, User

router = APIRouter(tags=["plans"], route_class=StrictRoute)

MOST_SOUGHT = 256
"""Largest number of stored paths that are looked at for those that the caller may see."""

_NEW: Responses = {201: {"model": PlanSummary, "description": "The path was added"}}


@router.get("/plans", response_model=FoundPlans, responses=KNOWN | problems(404))
async def find_plans(search: Annotated[PlanSearch, Query()], services: Provided, user: Caller) -> dict[str, Any]:
    """Find stored paths between two places on the current version of a map, shortest first."""
    head = await readable_head(services, user, search.map)
    start, goal = place_of(search.start), place_of(search.goal)
    await services.plan_writer.settled()

    def find() -> list[PlanRecord]:
        sought = plan_query.PlanStoreQuery(head.id, head.version, start, goal, search.tolerance, search.planner)
        is_shown = plans_shown(services.store, user, head)
        return list(filter(is_shown, services.store.find_plans(sought, limit=MOST_SOUGHT)))[: search.limit]

    return {"items": [summary_of(record) for record in await run_in_threadpool(find)]}


@router.put(
    "/plans/{plan_id}", response_model=PlanSummary, responses={**_NEW, **KNOWN, **BODY, **problems(403, 404, 409)}
)
async def put_plan(plan_id: PlanId, file: PlanPut, services: Provided, user: Caller, response: Response) -> PlanSummary:
    """Store a path under an id of your choice, or replace the path with this id if you may remove it."""
    # A path with this id may still wait to be written.
    await services.plan_writer.settled()
    try:
        before = await run_in_threadpool(services.store.plan, plan_id)
    except NotFound:
        record = await _record(plan_id, file, services, user)
        await run_in_threadpool(services.store.add_plan, record)
        response.status_code = 201
        return summary_of(record)
    await check_may_change(services, user, before)
    return await _replace(before, await _record(plan_id, file, services, user, before), services)


@router.patch("/plans/{plan_id}", response_model=PlanSummary, responses=KNOWN | BODY | problems(403, 404, 409))
async def change_plan(
    plan_id: PlanId,
    change: Annotated[PlanChange, Body(media_type=MERGE_PATCH)],
    services: Provided,
    user: Caller,
) -> PlanSummary:
    """Change a stored path by a JSON merge patch (RFC 7396); the type `application/json` is accepted too."""
    before = await visible_plan(services, user, plan_id)
    await check_may_change(services, user, before)
    file = _changed(before, change.model_dump(exclude_unset=True))
    if change.model_fields_set & {"map", "poses"}:
        return await _replace(before, await _record(plan_id, file, services, user, before), services)
    changed_fields = {name: getattr(file, name) for name in ("planner", "cost", "seconds", "parameters")}
    return await _replace(before, msgspec.structs.replace(before, origin="given", **changed_fields), services)


@router.get("/plans/{plan_id}/parts", response_model=Parts, responses=KNOWN | problems(404))
async def show_parts(plan_id: PlanId, services: Provided, user: Caller) -> dict[str, list[PlanPart]]:
    """List the segments of a path that are stored as entries, which other paths may share."""
    await visible_plan(services, user, plan_id)
    return {"items": await run_in_threadpool(services.store.plan_parts, plan_id)}


@router.get("/maps/{map_id}/plan_statistics", response_model=StatisticsAnswer, responses=KNOWN | problems(404))
async def show_statistics(map_id: MapId, services: Provided, user: Caller) -> PlanStatistics:
    """Return the number of stored paths on a map and the storage they use."""
    await readable_head(services, user, map_id)
    await services.plan_writer.settled()
    return await run_in_threadpool(services.store.plan_statistics, map_id)


async def _replace(before: PlanRecord, record: PlanRecord, services: Services) -> PlanSummary:
    await run_in_threadpool(services.store.replace_plan, record, instead_of=before)
    return summary_of(record)


async def _record(
    plan_id: str, file: PlanPut, services: Services, user: User, before: PlanRecord | None = None
) -> PlanRecord:
    """Return the record of a path on the current version of its map, from its first pose to its last."""
    head = await readable_head(services, user, file.map)
    poses = np.array(file.poses, "<f8")
    start, goal = ((row[0], row[1], yaw_of(*row[3:])) for row in poses[[0, -1]].tolist())
    return PlanRecord(
        id=plan_id,
        user=user.id if before is None else await _author(services, before) or user.id,
        map=head.id,
        version=head.version,
        planner=file.planner,
        start=start,
        goal=goal,
        length=length_between(poses[:, :2], 0, len(poses) - 1),
        cost=file.cost,
        seconds=file.seconds,
        poses=poses.tobytes(),
        created=epoch(),
        robot=None if before is None else before.robot,
        parameters=file.parameters,
        origin="given",
    )


def _changed(record: PlanRecord, change: dict[str, Any]) -> PlanPut:
    present = {name: getattr(record, name) for name in PlanPut.model_fields}
    present["poses"] = array_of(record.poses).tolist()
    try:
        return PlanPut.model_validate(merge(present, change))
    except ValidationError as error:
        raise RequestValidationError([{**fault, "loc": ("body", *fault["loc"])} for fault in error.errors()]) from error


async def _author(services: Services, record: PlanRecord) -> str:
    """Return the user who requested a stored path; empty if that user was removed, also if another has the id now."""
    author = await find_user(services.store, record.user)
    return record.user if author is not None and is_author(author, record) else ""
