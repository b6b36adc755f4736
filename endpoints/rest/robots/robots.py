"""Routes of the caller's robots."""

from typing import Annotated, Any

import msgspec
from fastapi import APIRouter, Body, Response
from fastapi.exceptions import RequestValidationError
from pydantic import ValidationError
from starlette.concurrency import run_in_threadpool

from endpoints.rest.dependencies import Caller, Paged, Provided, own_robot, readable_head, robots_in
from endpoints.rest.merge_patch import merge
from endpoints.rest.names import RobotId
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.paging import Page
from endpoints.rest.robots.schemas import RobotAnswer, RobotChange, RobotDetail, RobotFile, UrdfAnswer
from endpoints.rest.schemas import triple
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute
from endpoints.services.services import Services
from engine.specs.filter_masks import mask_heads
from ppaas.errors import Conflict, NotFound
from ppaas.maps.new_map import new_map_id
from ppaas.nodes.map_server.costmap_filters import check_no_masks
from ppaas.robot_model.describe import describe
from storage.records import RobotRecord, User

router = APIRouter(prefix="/robots", tags=["robots"], route_class=StrictRoute)


_NEW: Responses = {201: {"model": RobotAnswer, "description": "The robot is new"}}


@router.put("/{robot_id}", response_model=RobotAnswer, responses={**_NEW, **KNOWN, **BODY, **problems(404, 429)})
async def put_robot(
    robot_id: RobotId, file: RobotFile, services: Provided, user: Caller, response: Response
) -> RobotRecord:
    """Register a robot, or replace its file; a connected robot uses the new file when it connects again.

    Robots belong to the caller: two users may have robots with the same id.
    """
    await _check_map(services, user, file)
    await _check_masks(services, user, file)
    record = _record(robot_id, user, file)
    if await run_in_threadpool(_put, services, record):
        response.status_code = 201
    return record


@router.get("", response_model=Page[RobotAnswer], responses=KNOWN)
async def list_robots(services: Provided, user: Caller, paging: Paged) -> dict[str, object]:
    """List the caller's robots by id."""
    after = paging.key(str, "")
    found = await run_in_threadpool(services.store.robots, user.id, after=after, limit=paging.fetch_limit)
    return paging.page(found, lambda robot: robot.id)


@router.get("/{robot_id}", response_model=RobotDetail, responses=KNOWN | problems(404))
async def show_robot(robot_id: RobotId, services: Provided, user: Caller) -> RobotDetail:
    """Show a robot of the caller, with the contents of its URDF."""
    return await run_in_threadpool(_detail, services, user, robot_id)


@router.patch("/{robot_id}", response_model=RobotAnswer, responses=KNOWN | BODY | problems(404, 409))
async def change_robot(
    robot_id: RobotId,
    change: Annotated[RobotChange, Body(media_type=MERGE_PATCH)],
    services: Provided,
    user: Caller,
) -> RobotRecord:
    """Change a robot's file by a JSON merge patch (RFC 7396); the type `application/json` is accepted too."""
    before = await own_robot(services, user, robot_id)
    file = _merge(before, change.model_dump(exclude_unset=True))
    if file.map != before.map:
        await _check_map(services, user, file)
    if (file.map, file.parameters) != (before.map, before.parameters):
        await _check_masks(services, user, file)
    record = _record(robot_id, user, file)
    await run_in_threadpool(services.store.put_robot, record, instead_of=before)
    return record


@router.delete("/{robot_id}", status_code=204, responses=KNOWN | problems(404, 409))
async def remove_robot(robot_id: RobotId, services: Provided, user: Caller) -> None:
    """Remove a robot with its URDF and the checkpoints of its clone; refused (409) while it is connected."""
    if robot_id in robots_in(services, user.id):
        raise Conflict(f"robot {robot_id!r} is connected: disconnect it first")
    await run_in_threadpool(services.store.remove_robot, user.id, robot_id)
    services.usage.stored.forget_urdf(user.id, robot_id)


async def _check_map(services: Services, user: User, file: RobotFile) -> None:
    """Reject a file whose map is missing or unreadable now; a new map is checked when it is published."""
    if new_map_id(file.map) is None:
        await readable_head(services, user, file.map)


async def _check_masks(services: Services, user: User, file: RobotFile) -> None:
    """Reject a file whose masks are missing or unreadable now; they are looked up again when the robot connects."""
    if new_map_id(file.map) is not None:
        check_no_masks(file.parameters)
        return
    await run_in_threadpool(mask_heads, services.map_store, user.id, file.parameters)


def _put(services: Services, record: RobotRecord) -> bool:
    with services.usage.new_robot(services.store, services.cloud.quotas, record.user, record.id):
        return services.store.put_robot(record)


def _detail(services: Services, user: User, robot_id: str) -> RobotDetail:
    record = services.store.robot(user.id, robot_id)
    try:
        urdf = UrdfAnswer.model_validate(describe(services.store.urdf(user.id, robot_id)))
    except NotFound:
        urdf = None
    return RobotDetail(**msgspec.structs.asdict(record), urdf=urdf)


def _record(robot_id: str, user: User, file: RobotFile) -> RobotRecord:
    fields = file.model_dump() | {"initial_pose": triple(file.initial_pose)}
    return RobotRecord(id=robot_id, user=user.id, **fields)


def _merge(record: RobotRecord, change: dict[str, Any]) -> RobotFile:
    present = {name: getattr(record, name) for name in RobotFile.model_fields}
    try:
        return RobotFile.model_validate(merge(present | {"initial_pose": list(record.initial_pose)}, change))
    except ValidationError as error:
        raise RequestValidationError([{**fault, "loc": ("body", *fault["loc"])} for fault in error.errors()]) from error
