"""Route of the state of a building: its lifts and doors, and the journeys in it."""

from collections.abc import Callable

from fastapi import APIRouter
from starlette.concurrency import run_in_threadpool

from endpoints.accounts.tokens import ScopedUser
from endpoints.resources.services import Services
from endpoints.rest.buildings.access import readable_building
from endpoints.rest.buildings.state_schemas import (
    BuildingStateAnswer,
    DoorStateAnswer,
    JourneyAnswer,
    LiftStateAnswer,
    RideAnswer,
)
from endpoints.rest.dependencies import Caller, Provided
from endpoints.rest.names import BuildingAddress
from endpoints.rest.openapi import KNOWN, problems
from endpoints.rest.strict_json import StrictRoute
from endpoints.sharing.shared_robots import own_robots, robots_shared_with
from engine.control.buildings.views import DoorView, LiftView
from engine.control.journeys.views import JourneyView
from ppaas.errors import Unavailable
from storage.buildings.records import BuildingRecord
from storage.records import User

router = APIRouter(prefix="/buildings/{building_id}", tags=["buildings"], route_class=StrictRoute)

Named = Callable[[str], str | None]
"""Returns the address of a robot for the caller, given ``USER/ROBOT``; None if the caller may not know it."""


@router.get("/state", response_model=BuildingStateAnswer, responses=KNOWN | problems(404, 503))
async def show_building_state(building_id: BuildingAddress, services: Provided, user: Caller) -> BuildingStateAnswer:
    """Show the state of the lifts and doors of a building that have devices, and the journeys in it.

    The cloud connects to the devices for this, and stays connected for a minute.
    """
    record = await run_in_threadpool(readable_building, services.store, user, building_id)
    if services.journeys is None:
        raise Unavailable("no master leads lifts and doors for this endpoint")
    found = await services.journeys.building_state(*record.key)
    named = await run_in_threadpool(_names, services, user, record)
    return BuildingStateAnswer(
        building=record.present.number,
        lifts=[_lift(lift, named) for lift in found.devices.lifts],
        doors=[_door(door, named) for door in found.devices.doors],
        faults=found.devices.faults,
        journeys=[_journey(journey, named) for journey in found.journeys],
    )


def _names(services: Services, user: User, record: BuildingRecord) -> Named:
    """Return a function that names robots; owner of the building and administrators may know all; may block."""

    def named(robot: str) -> str:
        owner, _, name = robot.partition("/")
        return name if owner == user.id else f"{owner}:{name}"

    if not isinstance(user, ScopedUser) and (user.role == "admin" or user.id == record.user):
        return named
    reached = [one.record for one in robots_shared_with(services.store, user)]
    known = {f"{robot.user}/{robot.id}" for robot in (*own_robots(services.store, user), *reached)}
    return lambda robot: named(robot) if robot in known else None


def _lift(lift: LiftView, named: Named) -> LiftStateAnswer:
    rides = [
        RideAnswer(
            robot=named(ride.robot), origin=ride.origin, destination=ride.destination, phase=ride.phase,
            since=ride.since,
        )
        for ride in lift.rides
    ]  # fmt: skip
    return LiftStateAnswer(
        lift=lift.lift, fault=lift.fault, floor=lift.floor, target=lift.target, door=lift.door, motion=lift.motion,
        mode=lift.mode, session=lift.session, rides=rides,
    )  # fmt: skip


def _door(door: DoorView, named: Named) -> DoorStateAnswer:
    robots = [named(robot) for robot in door.robots]
    return DoorStateAnswer(floor=door.floor, door=door.door, mode=door.mode, fault=door.fault, robots=robots)


def _journey(journey: JourneyView, named: Named) -> JourneyAnswer:
    robot = named(f"{journey.user}/{journey.robot}")
    return JourneyAnswer(
        robot=robot, goal=None if robot is None else journey.id, on=journey.on, floor=journey.floor,
        phase=journey.phase, leg=journey.leg, state=journey.state, text="" if robot is None else journey.text,
        since=journey.since, ended=journey.ended,
    )  # fmt: skip
