"""Routes of robots, the caller's own and those that are shared with the caller, and of their nodes."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Annotated, Any, ClassVar, Literal

import msgspec
from fastapi import APIRouter, Body, Depends, Path, Query, Response
from fastapi.exceptions import RequestValidationError
from msgspec.structs import replace
from pydantic import Field, ValidationError
from starlette.concurrency import run_in_threadpool

from endpoints.resources import removal
from endpoints.resources.services import Services
from endpoints.rest.dependencies import Administered, AnyCaller, Looked, Paged, Provided, Removable
from endpoints.rest.names import Name, RobotAddress
from endpoints.rest.openapi import BODY, KNOWN, Responses, problems
from endpoints.rest.paging import Page, Paging
from endpoints.rest.robots.robot_status import status_of
from endpoints.rest.robots.robot_urdf import check_clone
from endpoints.rest.robots.schemas import (
    STORED_FIELDS,
    RobotAnswer,
    RobotChange,
    RobotDetail,
    RobotFile,
    RobotListed,
    UrdfAnswer,
)
from endpoints.rest.schemas import RequestBody, ResponseBody, triple
from endpoints.rest.strict_json import MERGE_PATCH, StrictRoute, merge
from endpoints.sharing.access import DESCRIPTION, PARAMETERS, access_of, may_hear
from endpoints.sharing.shared_robots import ReachedRobot, own_robots, reach, robots_shared_with
from engine.rights.globs import split_address
from engine.specs.clone_to_check import DEFAULTS
from engine.specs.robot_maps import mask_heads, no_mask
from engine.specs.robot_places import urdf_of
from engine.specs.robot_stops import why_stopped
from ppaas.clock import epoch
from ppaas.errors import Conflict, InvalidParameter, NotFound
from ppaas.maps.new_map import new_map_id
from ppaas.messages.ppaas_msgs import NodeHome
from ppaas.nodes.map_server.costmap_filters import filter_masks
from ppaas.robot_model.describe import describe
from ppaas.traffic.taking_part import TRAFFIC
from storage.records import RobotRecord, User

router = APIRouter(prefix="/robots", tags=["robots"], route_class=StrictRoute)


class RobotPaging(Paging):
    """Parameters of a page of robots."""

    filters: ClassVar[frozenset[str]] = frozenset({"shared"})


_NEW: Responses = {201: {"model": RobotAnswer, "description": "The robot is new"}}


@router.put("/{robot_id}", response_model=RobotAnswer, responses={**_NEW, **KNOWN, **BODY, **problems(403, 404, 429)})
async def put_robot(
    robot_id: RobotAddress, file: RobotFile, services: Provided, user: AnyCaller, response: Response
) -> RobotRecord:
    """Register a robot, or replace its file; a connected robot uses the new file when it connects again.

    Robots belong to the caller: two users may have robots with the same id.
    """
    owner, name = split_address(robot_id, user.id)
    before = await run_in_threadpool(_replaced, services, user, robot_id)
    await _check_map(services, user, owner, file)
    record = _record(name, owner, file)
    await check_clone(services, record, await run_in_threadpool(urdf_of, services.store, owner, name))
    await _check_masks(services, user, owner, file, {} if before is None else before.parameters)
    if before is None:
        await removal.make_robot_free(services, owner, name)
    if await services.usage.in_turn(owner, _put, services, record):
        response.status_code = 201
    services.shares.forget_robot(owner, name)
    return record


@router.get("", response_model=Page[RobotListed], responses=KNOWN)
async def list_robots(
    services: Provided,
    user: AnyCaller,
    paging: Annotated[RobotPaging, Depends()],
    shared: Annotated[
        bool, Query(description="List the robots that other users share with the caller instead")
    ] = False,
) -> dict[str, object]:
    """List the caller's robots by id; or those that are shared with the caller, by user and id."""
    limit = paging.fetch_limit
    if shared:
        last = paging.key(tuple[str, str], ("", ""))
        reached = await run_in_threadpool(robots_shared_with, services.store, user, after=last, limit=limit)
        return paging.page(await _listed(services, reached), lambda robot: (robot.user, robot.id))
    found = await run_in_threadpool(own_robots, services.store, user, after=paging.key(str, ""), limit=limit)
    own = [ReachedRobot(record, access_of(user, user.id, record.id, ())) for record in found]
    return paging.page(await _listed(services, own), lambda robot: robot.id)


@router.get("/{robot_id}", response_model=RobotDetail, responses=KNOWN | problems(403, 404))
async def show_robot(robot: Looked, services: Provided) -> RobotDetail:
    """Show a robot, with the contents of its URDF."""
    return await run_in_threadpool(_detail, services, robot)


@router.patch("/{robot_id}", response_model=RobotAnswer, responses=KNOWN | BODY | problems(403, 404, 409))
async def change_robot(
    robot: Administered,
    change: Annotated[RobotChange, Body(media_type=MERGE_PATCH)],
    services: Provided,
    user: AnyCaller,
) -> RobotRecord:
    """Change a robot's file by a JSON merge patch (RFC 7396); the type `application/json` is accepted too."""
    before = robot.record
    file = _merge(before, change.model_dump(exclude_unset=True))
    if file.map != before.map:
        await _check_map(services, user, robot.user, file)
    record = replace(_record(robot.id, robot.user, file), shares=before.shares, since=before.since)
    if any(getattr(record, name) != getattr(before, name) for name in ("map", *DEFAULTS)):
        await check_clone(services, record, await run_in_threadpool(urdf_of, services.store, robot.user, robot.id))
        await _check_masks(services, user, robot.user, file, before.parameters)
    await run_in_threadpool(services.store.put_robot, record, instead_of=before)
    return record


@router.delete("/{robot_id}", status_code=204, responses=KNOWN | problems(403, 404, 409))
async def remove_robot(robot: Removable, services: Provided) -> None:
    """Remove a robot with its URDF, recordings, checkpoints, shares, and the owner's tokens for it alone.

    That works with a damaged record, too.

    It is refused (409) while the robot is connected. A container that waits for it to come back ends first, and with it
    the sockets of its operators.
    """
    owner, name = robot
    [view] = await services.cloud.robot_views([robot])
    if view is not None and view.connected:
        raise Conflict(f"robot {name!r} is connected: disconnect it first")
    await services.cloud.users.end_places(owner, NotFound("robot", name), name)
    await removal.remove_robot(services, owner, name)


async def _listed(services: Services, robots: Sequence[ReachedRobot]) -> list[RobotListed]:
    views = await services.cloud.robot_views([(robot.user, robot.id) for robot in robots])
    stopped = await services.stops.why_stopped(services.store, [robot.record for robot in robots])
    return [
        RobotListed(
            **msgspec.structs.asdict(robot.record)
            | status_of(view, robot.access, why).model_dump()
            | {"stopped": why}
            | _shown(robot)
        )
        for robot, view, why in zip(robots, views, stopped, strict=True)
    ]


def _replaced(services: Services, user: User, address: str) -> RobotRecord | None:
    """Return the robot that a file replaces, None for a new one; raise unless the caller may put it."""
    owner, name = split_address(address, user.id)
    try:
        robot = reach(services.store, user, address)
    except NotFound:
        if owner != user.id:
            raise
        access_of(user, owner, name, ()).check_role("administer")
        return None
    robot.access.check_role("administer")
    return robot.record


async def _check_map(services: Services, user: User, owner: str, file: RobotFile) -> None:
    """Reject a file whose map is missing or unreadable now; a new map is checked when it is published.

    A map that the owner of the robot reads, and the caller does not, is refused too: it would be shown to the caller.
    """
    if new_map_id(file.map) is not None:
        return
    head = await services.map_cache.head(services.map_store, file.map)
    if user.role != "admin" and not head.readable_by(user.id):
        raise NotFound("map", file.map)
    if not head.readable_by(owner):
        raise InvalidParameter(f"map {file.map!r} is not shared with {owner!r}, to whom the robot belongs")


async def _check_masks(services: Services, user: User, owner: str, file: RobotFile, before: dict[str, Any]) -> None:
    """Reject a file that names masks, other than before, that its owner reads, and the caller does not."""
    if owner == user.id or user.role == "admin" or new_map_id(file.map) is not None:
        return
    heads = await run_in_threadpool(mask_heads, services.map_store, owner, file.parameters)
    known = set(filter_masks(before).values())
    for name, head in heads.items():
        if head.id not in known and not head.readable_by(user.id):
            raise no_mask(name, head.id)


def _put(services: Services, record: RobotRecord) -> bool:
    """Store a robot, and keep with whom it is shared; return whether it is new."""
    with services.usage.new_robot(services.store, services.cloud.quotas, record.user, record.id):
        while True:
            try:
                before = services.store.robot(record.user, record.id)
            except NotFound:
                return services.store.put_robot(replace(record, since=epoch()))
            with suppress(Conflict):  # it was changed meanwhile
                return services.store.put_robot(
                    replace(record, shares=before.shares, since=before.since), instead_of=before
                )


def _detail(services: Services, robot: ReachedRobot) -> RobotDetail:
    urdf = None
    if may_hear(robot.access, DESCRIPTION):
        with suppress(NotFound):
            urdf = UrdfAnswer.model_validate(describe(services.store.urdf(robot.user, robot.id)))
    [stopped] = why_stopped(services.store, [robot.record])
    return RobotDetail(**msgspec.structs.asdict(robot.record) | {"urdf": urdf, "stopped": stopped} | _shown(robot))


def _shown(robot: ReachedRobot) -> dict[str, Any]:
    """Return the fields of an answer that depend on the caller's rights."""
    hidden = {} if may_hear(robot.access, PARAMETERS) else {"parameters": None}
    return {"role": robot.access.role} | hidden


def _record(robot_id: str, user: str, file: RobotFile) -> RobotRecord:
    fields = file.model_dump() | {"initial_pose": triple(file.initial_pose)}
    return RobotRecord(id=robot_id, user=user, **fields)


def _merge(record: RobotRecord, change: dict[str, Any]) -> RobotFile:
    present = {name: getattr(record, name) for name in STORED_FIELDS} | {"initial_pose": list(record.initial_pose)}
    others = {name: value for name, value in change.items() if name != TRAFFIC}
    merged = merge(present, others)
    if TRAFFIC in change:
        given = change[TRAFFIC]
        section = None if given in (False, None) else {} if given is True else given
        merged = merge(merged, {"parameters": {TRAFFIC: section}})
    try:
        return RobotFile.model_validate(merged)
    except ValidationError as error:
        raise RequestValidationError([{**fault, "loc": ("body", *fault["loc"])} for fault in error.errors()]) from error


# Nodes: whether each runs in the cloud or on the robot, and why.

Home = Literal["cloud", "robot"]
NodeName = Annotated[Name, Path(examples=["move_base"])]


class NodeAnswer(ResponseBody):
    """Node of a robot."""

    node: str
    home: Home = Field(description="Home of the node: where it runs")
    wanted: Home = Field(description="Home that was decided; a connected robot takes the node over within a second")
    score: float = Field(description="Score from -1, entirely for the robot, to 1, entirely for the cloud")
    reasons: list[str] = Field(description="Reasons of the decision, most important first")


class NodeRequest(RequestBody):
    """Home to run a node in."""

    home: Home | None = Field(default=None, description="Home of the node; null: the node monitor decides")


@router.get("/{robot_id}/nodes", response_model=Page[NodeAnswer], responses=KNOWN | problems(403, 404, 503))
async def list_nodes(robot: Looked, services: Provided, paging: Paged) -> dict[str, object]:
    """List the nodes of a connected robot by name, with their homes and the reasons."""
    homes = sorted(await services.cloud.nodes.homes(robot.user, robot.id), key=lambda home: home.node)
    after = paging.key(str, "")
    return paging.page([home for home in homes if home.node > after], lambda home: home.node)


@router.post("/{robot_id}/nodes/{node}", response_model=NodeAnswer, responses=KNOWN | BODY | problems(403, 404, 503))
async def run_node(robot: Administered, node: NodeName, request: NodeRequest, services: Provided) -> NodeHome:
    """Move a node of a robot to a home, or let the node monitor choose its home."""
    return await services.cloud.nodes.run(robot.user, robot.id, node, request.home or "")
