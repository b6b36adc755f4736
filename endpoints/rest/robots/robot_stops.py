"""Routes of stops: one robot, the robots on a map, or all robots stand until somebody releases them by name."""

from collections.abc import Callable, Iterable
from typing import Annotated

from fastapi import APIRouter, Request
from pydantic import ConfigDict, Field
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.tokens import ScopedUser
from endpoints.audit.requests import note_details
from endpoints.resources.services import Services
from endpoints.rest.dependencies import AnyCaller, Caller, Driven, Paged, Provided, readable_head
from endpoints.rest.names import MapId
from endpoints.rest.openapi import BODY, KNOWN, problems
from endpoints.rest.paging import Page
from endpoints.rest.schemas import RequestBody, ResponseBody
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.access import access_of
from endpoints.sharing.shared_robots import ReachedRobot, own_robots, robots_shared_with
from engine.control.robot_stops import StopOrder, StopReport
from engine.specs.robot_stops import stops_of_robot, stored_stops
from ppaas.clock import epoch
from ppaas.errors import NotPermitted
from ppaas.messages.health.stops import ALL, MAP, ROBOT, RobotStop
from ppaas.nodes.stop.node import LONGEST_REASON
from storage.records import User

router = APIRouter(tags=["stops"], route_class=StrictRoute)

Reason = Annotated[str, Field(max_length=LONGEST_REASON, description="Why, for those who read it later")]


class StopRequest(RequestBody):
    """Reason of a stop or a release."""

    model_config = ConfigDict(json_schema_extra={"examples": [{"reason": "a pallet has fallen in aisle 4"}]})

    reason: Reason = ""


class StopAnswer(ResponseBody):
    """A stop that is in force."""

    user: str = Field(description="Owner of the robots")
    scope: str = Field(description="`robot`, `map` or `all`: one robot, the owner's robots on a map, all of them")
    name: str = Field(description="Id of the robot or the map; empty for `all`")
    by: str = Field(description="User who stopped them")
    since: float = Field(description="Time of the stop [s since the epoch]")
    reason: str

    @classmethod
    def of(cls, user: str, stop: RobotStop) -> "StopAnswer":
        """Return a stop of the robots of a user as JSON."""
        return cls(user=user, scope=stop.scope, name=stop.name, by=stop.by, since=stop.since, reason=stop.reason)


class StoppedAnswer(ResponseBody):
    """What was stopped."""

    stops: list[StopAnswer] = Field(description="Stops in force; an earlier one of the same scope and name stays")
    standing: list[str] = Field(
        description="Robots whose clones have confirmed that they send nothing but zero, and that run Move Base "
        "there or have confirmed the stop themselves"
    )
    unconfirmed: list[str] = Field(
        description="Robots whose clones have not confirmed it within 1 s; they get the stop as soon as they can be "
        "reached. Robots that are not connected are not listed: they are stopped when they connect"
    )


class ReleasedAnswer(ResponseBody):
    """What was released."""

    released: list[StopAnswer] = Field(description="Empty if nothing was stopped")
    left: list[StopAnswer] = Field(description="Stops that still hold the robots, each to be released by its name")


# -- one robot ---------------------------------------------------------------------------------------------------------

_STOP = KNOWN | BODY | problems(403, 404, 503)


@router.post("/robots/{robot_id}/stop", response_model=StoppedAnswer, responses=_STOP)
async def stop_robot(robot: Driven, request: StopRequest, services: Provided, user: AnyCaller) -> StoppedAnswer:
    """Stop a robot, connected or not, until it is released; its goals wait. A second stop changes nothing."""
    return await _stop(services, user, [_order(robot, user, request.reason)])


@router.post("/robots/{robot_id}/release", response_model=ReleasedAnswer, responses=_STOP)
async def release_robot(
    robot: Driven, _recorded: StopRequest, services: Provided, user: AnyCaller, request: Request
) -> ReleasedAnswer:
    """Release a robot: it drives on. Who stopped it may do this, and who may administer the robot."""
    released = await _release_robots(services, user, [robot])
    stops = await run_in_threadpool(stored_stops, services.store, robot.user)
    left = [StopAnswer.of(robot.user, stop) for stop in stops_of_robot(stops, robot.id, robot.record.map)]
    return _noted(request, ReleasedAnswer(released=released, left=left))


# -- the robots on a map, and all robots -------------------------------------------------------------------------------


@router.post("/maps/{map_id}/stop", response_model=StoppedAnswer, responses=_STOP)
async def stop_map(map_id: MapId, request: StopRequest, services: Provided, user: Caller) -> StoppedAnswer:
    """Stop the caller's robots on a map, also those that connect later, until they are released."""
    await readable_head(services, user, map_id)
    return await _stop(services, user, [StopOrder(user.id, RobotStop(MAP, map_id, user.id, epoch(), request.reason))])


@router.post("/maps/{map_id}/release", response_model=ReleasedAnswer, responses=_STOP)
async def release_map(
    map_id: MapId, _recorded: StopRequest, services: Provided, user: Caller, request: Request
) -> ReleasedAnswer:
    """Release the caller's robots on a map; robots that were stopped by their name or with all others still stand."""
    return _noted(request, await _release_own(services, user, MAP, map_id))


@router.post("/stop", response_model=StoppedAnswer, responses=_STOP)
async def stop_all(request: StopRequest, services: Provided, user: AnyCaller) -> StoppedAnswer:
    """Stop all robots of the caller, also those that connect later, and those of others that the caller may drive.

    A token for some robots stops these.
    """
    driven = await run_in_threadpool(_may_stop, services, user)
    orders = [_order(robot, user, request.reason) for robot in driven]
    if not isinstance(user, ScopedUser):
        orders.insert(0, StopOrder(user.id, RobotStop(ALL, "", user.id, epoch(), request.reason)))
    return await _stop(services, user, orders)


@router.post("/release", response_model=ReleasedAnswer, responses=_STOP)
async def release_all(_recorded: StopRequest, services: Provided, user: AnyCaller, request: Request) -> ReleasedAnswer:
    """Release what a stop of all robots has stopped; robots of the caller that were stopped by name still stand."""
    released = await _release_robots(services, user, await run_in_threadpool(_stopped_by, services, user))
    if isinstance(user, ScopedUser):
        return _noted(request, ReleasedAnswer(released=released, left=[]))
    own = await _release_own(services, user, ALL, "")
    return _noted(request, ReleasedAnswer(released=[*own.released, *released], left=own.left))


@router.get("/stops", response_model=Page[StopAnswer], responses=KNOWN)
async def list_stops(services: Provided, user: AnyCaller, paging: Paged) -> dict[str, object]:
    """List the stops in force that stop a robot of the caller, or one that the caller may drive, by owner and name."""
    after = paging.key(tuple[str, str, str], ("", "", ""))
    stops = [stop for stop in await run_in_threadpool(_visible, services, user) if _key(stop) > after]
    return paging.page(stops, _key)


# -- internals ---------------------------------------------------------------------------------------------------------


def _noted(request: Request, answer: ReleasedAnswer) -> ReleasedAnswer:
    """Note for the audit log who made the stops that were released."""
    note_details(request.scope, stopped_by=sorted({stop.by for stop in answer.released}))
    return answer


def _key(stop: StopAnswer) -> tuple[str, str, str]:
    return stop.user, stop.scope, stop.name


def _order(robot: ReachedRobot, user: User, reason: str) -> StopOrder:
    return StopOrder(robot.user, RobotStop(ROBOT, robot.id, user.id, epoch(), reason))


async def _stop(services: Services, user: User, orders: list[StopOrder]) -> StoppedAnswer:
    try:
        reports = await services.cloud.stops.stop(orders)
    finally:
        services.stops.forget_users(order.user for order in orders)
    return StoppedAnswer(
        stops=[StopAnswer.of(report.user, report.stop) for report in reports],
        standing=_addresses(user, reports, lambda report: report.standing),
        unconfirmed=_addresses(user, reports, lambda report: report.unconfirmed),
    )


def _addresses(user: User, reports: Iterable[StopReport], robots: Callable[[StopReport], tuple[str, ...]]) -> list[str]:
    found = {(report.user, robot) for report in reports for robot in robots(report)}
    return [robot if owner == user.id else f"{owner}:{robot}" for owner, robot in sorted(found)]


async def _release_robots(services: Services, user: User, robots: Iterable[ReachedRobot]) -> list[StopAnswer]:
    released = []
    for robot in robots:
        of_others = robot.access.role == "administer"
        stop = await services.cloud.stops.release(robot.user, ROBOT, robot.id, user.id, of_others)
        services.stops.forget_users([robot.user])
        released += [] if stop is None else [StopAnswer.of(robot.user, stop)]
    return released


def _driven(services: Services, user: User) -> list[ReachedRobot]:
    """Return the robots that a caller may drive: those of others, and the caller's own if the token is for some."""
    reached = robots_shared_with(services.store, user)
    if isinstance(user, ScopedUser):
        own = own_robots(services.store, user)
        reached += [ReachedRobot(record, access_of(user, user.id, record.id, ())) for record in own]
    return [robot for robot in reached if robot.access.role != "look"]


def _may_stop(services: Services, user: User) -> list[ReachedRobot]:
    """Return the robots that a caller may drive; ``NotPermitted`` if a token is for none, and nothing is stopped."""
    driven = _driven(services, user)
    if isinstance(user, ScopedUser) and not driven:
        raise NotPermitted("this token drives no robot, so it stops and releases none: use another token")
    return driven


def _stopped_by(services: Services, user: User) -> list[ReachedRobot]:
    """Return the robots that the caller may drive, and has stopped; raises as ``_may_stop``."""
    driven = _may_stop(services, user)
    owners = {robot.user for robot in driven}
    mine = {(owner, stop.key) for owner in owners for stop in stored_stops(services.store, owner) if stop.by == user.id}
    return [robot for robot in driven if (robot.user, (ROBOT, robot.id)) in mine]


def _visible(services: Services, user: User) -> list[StopAnswer]:
    driven = _driven(services, user)
    owners = {robot.user for robot in driven} | (set() if isinstance(user, ScopedUser) else {user.id})
    stops = {owner: stored_stops(services.store, owner) for owner in owners}
    apply = {
        (robot.user, stop.key): stop
        for robot in driven
        for stop in stops_of_robot(stops[robot.user], robot.id, robot.record.map)
    }
    if not isinstance(user, ScopedUser):
        apply |= {(user.id, stop.key): stop for stop in stops[user.id]}
    return sorted((StopAnswer.of(owner, stop) for (owner, _), stop in apply.items()), key=_key)


async def _release_own(services: Services, user: User, scope: str, name: str) -> ReleasedAnswer:
    stop = await services.cloud.stops.release(user.id, scope, name, user.id, of_others=True)
    services.stops.forget_users([user.id])
    left = await run_in_threadpool(stored_stops, services.store, user.id)
    return ReleasedAnswer(
        released=[] if stop is None else [StopAnswer.of(user.id, stop)],
        left=[StopAnswer.of(user.id, one) for one in left],
    )
