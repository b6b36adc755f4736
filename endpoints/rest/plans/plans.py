"""Route of a stored path by its id."""

from typing import Annotated, Any

from fastapi import APIRouter, Depends
from starlette.concurrency import run_in_threadpool
from starlette.responses import Response

from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.names import PlanId
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.plans.representations import Representation, asked, described
from endpoints.rest.plans.schemas import PlanAnswer
from endpoints.rest.plans.stored_plans import visible_plan
from endpoints.rest.strict_json import StrictRoute
from storage.plan_checks import array_of
from storage.records import PlanRecord

router = APIRouter(tags=["plans"], route_class=StrictRoute)


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
    fields = path_of(record) | request | {"poses": poses.tolist() if as_given else poses}
    # Encoded here: FastAPI would validate each of thousands of numbers. In a thread: the first may load kernels.
    return Response(await run_in_threadpool(wanted.encode, fields), media_type=wanted.media_type)


def path_of(record: PlanRecord) -> dict[str, Any]:
    """Return the fields that every response with a path has, without its poses."""
    return {
        "plan_id": record.id,
        "length": record.length,
        "cost": record.cost,
        "seconds": record.seconds,
        "planner": record.planner,
        "map": record.map,
        "version": record.version,
    }
