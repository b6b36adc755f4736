"""Routes that list, show and remove stored paths, and the permissions on them."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.resources.services import Services
from endpoints.rest.dependencies import Caller, Paged, Provided, readable_head
from endpoints.rest.names import MapId, PlanId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.plans.representations import Representation, asked, described
from endpoints.rest.plans.schemas import PlanAnswer, PlanSummary
from endpoints.sharing.shared_robots import is_author, plans_shown
from ppaas.errors import NotFound, NotPermitted
from storage.plan_checks import array_of
from storage.ports import Store
from storage.records import MapRecord, PlanRecord, User

router = APIRouter(tags=["plans"])


@router.get("/maps/{map_id}/plans", response_model=Page[PlanSummary], responses=KNOWN | problems(404))
async def list_plans(map_id: MapId, services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the stored paths of all users on a map that you may read, newest first and without their poses.

    If only a robot that is shared with you shows you the map, these are your plans, and plans of robots whose topic
    `plan` you may subscribe to.
    """
    head = await readable_head(services, user, map_id)
    before = paging.key(tuple[float, str], None)
    await services.plan_writer.settled()
    found = await run_in_threadpool(_page, services.store, user, head, before, paging.fetch_limit)
    return paging.page([summary_of(record) for record in found], lambda plan: (plan.created, plan.plan_id))


@router.get("/plans/{plan_id}", response_model=PlanAnswer, responses=described(200) | KNOWN | problems(404))
async def show_plan(
    plan_id: PlanId, services: Provided, user: Caller, wanted: Annotated[Representation, Depends(asked)]
) -> Response:
    """Return a stored path: your own, or one on a map that you may read."""
    record = await visible_plan(services, user, plan_id)
    request = {name: getattr(record, name) for name in ("user", "robot", "start", "goal", "created")}
    poses = array_of(record.poses)
    # A program's own numbers are returned as they are; planners' numbers are rounded as in their first answer.
    as_given = record.origin == "given" and wanted == Representation()
    fields = _path_of(record) | request | {"poses": poses.tolist() if as_given else poses}
    # Encoded here: FastAPI would validate each of thousands of numbers. In a thread: the first may load kernels.
    return Response(await run_in_threadpool(wanted.encode, fields), media_type=wanted.media_type)


@router.delete("/plans/{plan_id}", status_code=204, responses=KNOWN | problems(403, 404))
async def remove_plan(plan_id: PlanId, services: Provided, user: Caller) -> None:
    """Remove a stored path. The user who requested it, the owner of its map and an administrator may."""
    await check_may_change(services, user, await visible_plan(services, user, plan_id))
    if not await services.plan_writer.forget(lambda record: record.id == plan_id):
        await run_in_threadpool(services.store.remove_plan, plan_id)


async def check_may_change(services: Services, user: User, record: PlanRecord) -> None:
    """Raise ``NotPermitted`` unless the user requested this path, owns its map, or is an administrator."""
    if user.role != "admin" and not is_author(user, record):
        head = await readable_head(services, user, record.map)
        if user.id != head.owner:
            raise NotPermitted(f"plan {record.id!r} may be changed or removed only by its user or the owner of its map")


async def visible_plan(services: Services, user: User, plan_id: str) -> PlanRecord:
    """Return a stored path; ``NotFound`` unless it is the user's own or on a map that the user may read."""
    await services.plan_writer.settled()
    record = services.plan_writer.unstored(plan_id)
    if record is None:
        record = await run_in_threadpool(services.store.plan, plan_id)
    if not is_author(user, record):
        try:
            head = await readable_head(services, user, record.map)
        # The same answer as for a plan that does not exist: a stranger learns no ids.
        except NotFound as error:
            raise NotFound("plan", plan_id) from error
        if not (await run_in_threadpool(plans_shown, services.store, user, head))(record):
            raise NotFound("plan", plan_id)
    return record


def _page(
    store: Store, user: User, head: MapRecord, before: tuple[float, str] | None, limit: int | None
) -> list[PlanRecord]:
    """Return the first stored paths on a map that a user may see; blocks."""
    is_shown, found = plans_shown(store, user, head), list[PlanRecord]()
    while limit is None or len(found) < limit:
        read = store.plans(head.id, before=before, limit=limit)
        found += filter(is_shown, read)
        if limit is None or len(read) < limit:
            break
        before = read[-1].created, read[-1].id
    return found[:limit]


def summary_of(record: PlanRecord) -> PlanSummary:
    """Return a stored path without its poses."""
    fields = {name: getattr(record, name) for name in PlanSummary.model_fields if name != "plan_id"}
    return PlanSummary(plan_id=record.id, **fields)


def _path_of(record: PlanRecord) -> dict[str, Any]:
    return {
        "plan_id": record.id,
        "length": record.length,
        "cost": record.cost,
        "seconds": record.seconds,
        "planner": record.planner,
        "map": record.map,
        "version": record.version,
    }
