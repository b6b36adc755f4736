"""Site: one building whose robots are on journeys. It obeys the orders of journeys, and reports what happens."""

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field

from engine.control.buildings.building_runner import (
    BuildingAlert,
    BuildingHooks,
    BuildingRunner,
    RobotOrder,
    steady_epoch,
)
from engine.control.journeys.floor_parts import floor_request
from engine.control.journeys.kept import KeptJourneys
from engine.control.journeys.rider import Rider
from engine.control.journeys.views import JourneyView, LiftWait, SiteView
from engine.control.views import GoalView
from engine.devices.hosts import DeviceHosts
from engine.processes.background import Background
from ppaas.buildings.building import Building
from ppaas.buildings.journeys.journey import JourneyMachine
from ppaas.buildings.journeys.records import (
    AskForDoor,
    AskForLift,
    CancelGoal,
    CancelRide,
    ChangeFloor,
    DoorPassed,
    EnteredCar,
    FindLegs,
    Journey,
    JourneyLeg,
    JourneyOrder,
    Keep,
    LeftCar,
    LookForFloor,
    SendGoal,
)
from ppaas.buildings.layout import BuildingLayout, Place
from ppaas.buildings.lifts.states import LiftRide, RemoveRide, StoreRide
from ppaas.buildings.riding.floor_maps import pose_of
from ppaas.clock import Clock
from ppaas.errors import Conflict, InvalidInput, NotFound, PPaaSError, Unavailable
from ppaas.messages.fleet.floors import FindFloorRequest, FloorPart

logger = logging.getLogger(__name__)

TICK = 0.2
"""Time between two looks at the robots [s]."""

FIRST_REPORTS = 2.0
"""Time for which who looks at a site that was just opened waits for the first reports of its devices [s]."""

ENDED = 20
"""Number of journeys that have ended that a site remembers."""

PAUSE = 0.5
"""Time after which an order that could not be obeyed is tried again [s]."""


@dataclass(frozen=True, slots=True)
class SiteHooks:
    """What a site needs of the rest of the master.

    Parameters
    ----------
    rider : callable
        Returns the rider of a journey; it calls with each goal that has ended.
    plan : callable
        Plans the legs of a journey from a pose.
    keep : callable
        Stores journeys and rides of the building.
    changed : callable
        Called with each journey whose record has changed.
    parts : callable
        Returns the parts of the maps around the lift of a journey, by floor.
    alert : callable
        Called with what people must look at, and with lifts and doors that have a fault or serve again.
    waited : callable
        Called with the time that each robot that boards a lift has waited for it [s].
    """

    rider: Callable[[Journey, Callable[[GoalView], None]], Rider]
    plan: Callable[[Journey, Place], Awaitable[list[JourneyLeg]]]
    keep: Callable[[list[Journey], list[LiftRide]], Awaitable[None]]
    changed: Callable[[Journey], None]
    parts: Callable[[Journey], Awaitable[dict[str, FloorPart]]]
    alert: Callable[[BuildingAlert], None] = lambda _alert: None
    waited: Callable[[float], None] = lambda _seconds: None


@dataclass(slots=True)
class _Traveller:
    """A journey that is led: machine, robot, orders that wait, where its clone goes, and the record last published."""

    machine: JourneyMachine
    rider: Rider
    orders: asyncio.Queue[JourneyOrder] = field(default_factory=asyncio.Queue)
    moving: str = ""
    known: Journey | None = None


def robot_name(journey: Journey) -> str:
    """Return the name of the robot of a journey among all robots in a building, which several users may have."""
    return f"{journey.user}/{journey.robot}"


class JourneySite:
    """Leads the journeys in a building.

    Parameters
    ----------
    name : str
        Name of the building in sessions of lifts.
    layout : BuildingLayout
        Its places, as it was when the site was opened.
    hooks : SiteHooks
    hosts : DeviceHosts
        Hosts that devices may have.
    kept : KeptJourneys
        What is stored; stored journeys go on.
    clock : Clock, optional
        Clock of journeys, lifts and doors [s since the epoch].
    """

    def __init__(
        self,
        name: str,
        layout: BuildingLayout,
        hooks: SiteHooks,
        hosts: DeviceHosts,
        *,
        kept: KeptJourneys,
        clock: Clock | None = None,
    ) -> None:
        self.layout, self._hooks = layout, hooks
        self._clock = steady_epoch() if clock is None else clock
        self._rides = {ride.robot: ride for ride in kept.rides}
        self._travellers: dict[str, _Traveller] = {}
        self._ended: deque[Journey] = deque(maxlen=ENDED)
        self._background = Background()
        self._saving = asyncio.Lock()
        runner_hooks = BuildingHooks(self._ordered, self._store_ride, self._connected, hooks.alert)
        self.runner = BuildingRunner(name, layout, runner_hooks, hosts, rides=kept.rides, clock=self._clock)
        for journey in kept.journeys:
            self.begin(journey)

    @property
    def building(self) -> Building:
        """The building, as it was when the site was opened."""
        return self.layout.building

    @property
    def is_idle(self) -> bool:
        """Whether no robot is on a journey or in a lift, and all of that is stored."""
        return not self._travellers and not self._rides and not self._saving.locked()

    @property
    def journeys(self) -> list[Journey]:
        """Journeys that have not ended."""
        return [each.machine.journey for each in self._travellers.values()]

    @property
    def waits(self) -> list[LiftWait]:
        """Waits that are expected now, of the lifts that are known."""
        return [LiftWait(lift, floor, wait) for (lift, floor), wait in self.runner.waits().items()]

    async def view(self) -> SiteView:
        """Return the state of lifts and doors, after their first reports or a while, and the journeys."""
        for _ in range(round(FIRST_REPORTS / TICK)):
            if self.runner.has_heard_all:
                break
            await asyncio.sleep(TICK)
        return SiteView(self.runner.view(), [_view_of(journey) for journey in (*self._ended, *self.journeys)])

    async def run(self) -> None:
        """Lead the building until cancelled."""
        self._background.run(self.runner.run())
        try:
            while True:
                self._look()
                await asyncio.sleep(TICK)
        finally:
            await self._background.cancel()
            for traveller in self._travellers.values():
                traveller.rider.leave()

    def begin(self, journey: Journey) -> None:
        """Begin a journey, or go on with one."""
        robot = robot_name(journey)
        rider = self._hooks.rider(journey, lambda goal: self._goal_ended(robot, goal))
        traveller = self._travellers[robot] = _Traveller(JourneyMachine(journey, self.layout), rider)
        self._take(traveller, traveller.machine.resume())
        self._background.run(self._obey(robot, traveller))

    def cancel(self, journey: Journey) -> Journey:
        """Cancel a journey; return its record."""
        traveller = self._travellers.get(robot_name(journey))
        if traveller is None or traveller.machine.journey.id != journey.id:
            return journey
        self._take(traveller, traveller.machine.cancel(self._clock()))
        return traveller.machine.journey

    # -- events --------------------------------------------------------------------------------------------------------

    def _look(self) -> None:
        """Tell journeys where their robots are, which doors have closed, and which lifts are out of order."""
        broken = self.runner.out_of_order()
        for traveller in tuple(self._travellers.values()):
            machine, rider = traveller.machine, traveller.rider
            for lift, text in broken.items():
                self._take(traveller, machine.lift_lost(lift, text, self._clock()))
            pose, floor = rider.pose, self.layout.building.floor_of_map(rider.map)
            if floor is None or pose is None:
                continue
            if traveller.moving not in ("", floor.name):
                continue
            traveller.moving = ""
            self._take(traveller, machine.on_floor(floor.name))
            self._take(traveller, machine.seen_at(floor.name, pose, self._clock()))
            if machine.journey.phase in ("inside", "alighting") and self._is_shut(machine.journey.now.name):
                self._take(traveller, machine.doors_closed(self.runner.lifts.target(machine.journey.now.name)))

    def _is_shut(self, lift: str) -> bool:
        car = self.runner.lifts.cars.get(lift)
        return car is not None and car.state is not None and car.state.door == "closed"

    def _goal_ended(self, robot: str, goal: GoalView) -> None:
        traveller = self._travellers.get(robot)
        if traveller is None:
            return
        machine, now = traveller.machine, self._clock()
        if goal.state == "canceled" and goal.id == machine.journey.goal_id and not machine.journey.is_aboard:
            self._take(traveller, machine.cancel(now))  # by a client, or since another goal was sent
        else:
            self._take(traveller, machine.goal_ended(goal.id, goal.state == "succeeded", goal.text, now))

    def _ordered(self, order: RobotOrder) -> None:
        traveller = self._travellers.get(order.robot)
        if traveller is not None:
            self._take(traveller, traveller.machine.obey(order, self._clock()))

    def _connected(self) -> list[str]:
        return [robot for robot, traveller in self._travellers.items() if traveller.rider.is_here]

    # -- orders --------------------------------------------------------------------------------------------------------

    def _take(self, traveller: _Traveller, orders: list[JourneyOrder]) -> None:
        before, traveller.known = traveller.known, traveller.machine.journey
        if not orders and before is traveller.known:
            return
        for order in orders:
            traveller.orders.put_nowait(order)
            if isinstance(order, ChangeFloor):
                traveller.moving = order.floor
        self._hooks.changed(traveller.machine.journey)

    async def _obey(self, robot: str, traveller: _Traveller) -> None:
        """Obey the orders of a journey in turn, each until that is done, and end with the journey."""
        while not (traveller.machine.is_over and traveller.orders.empty()):
            order = await traveller.orders.get()
            while True:
                try:
                    await self._obey_one(robot, traveller, order)
                    break
                except PPaaSError as error:
                    logger.info("robot %s waits on its journey: %s", robot, error)
                    await asyncio.sleep(PAUSE)
        self._ended.append(traveller.machine.journey)
        if self._travellers.get(robot) is traveller:
            del self._travellers[robot]
        traveller.rider.leave()
        await self._save()

    async def _obey_one(self, robot: str, traveller: _Traveller, order: JourneyOrder) -> None:
        machine = traveller.machine
        match order:
            case Keep():
                await self._save()
            case SendGoal(goal_id, pose):
                if goal_id == machine.journey.goal_id and not machine.is_over:  # else another event has overtaken it
                    traveller.rider.send(goal_id, pose)
            case CancelGoal(goal_id):
                traveller.rider.cancel(goal_id)
            case FindLegs(number):
                if number == machine.journey.plans and not machine.is_over:
                    await self._plan(traveller, number)
            case LookForFloor():
                self._background.run(self._look_for_floor(traveller))
            case EnteredCar():
                await self._measure(traveller)
                self._ask(robot, order)
            case ChangeFloor(floor, pose):
                await traveller.rider.change_map(self.layout.building.floor(floor).map, pose)
            case _:
                self._ask(robot, order)

    def _ask(self, robot: str, order: JourneyOrder) -> None:
        """Pass what a journey asks of lifts and doors to their controllers."""
        match order:
            case AskForLift(lift, origin, destination):
                self.runner.request(robot, lift, origin, destination)
            case EnteredCar():
                self.runner.entered(robot)
            case LeftCar():
                self.runner.left(robot)
            case CancelRide():
                self.runner.cancel(robot)
            case AskForDoor(floor, door):
                self.runner.approach(robot, floor, door)
            case DoorPassed(floor, door):
                self.runner.passed(robot, floor, door)

    async def _measure(self, traveller: _Traveller) -> None:
        """Note the pressure of the air, if the robot has a barometer, before the car may leave."""
        if traveller.machine.journey.pressure:
            return
        try:
            answer = await traveller.rider.find_floor(FindFloorRequest())
        except PPaaSError as error:
            logger.debug("no barometer is asked: %s", error)
        else:
            if answer.pressure:
                self._take(traveller, traveller.machine.measured(answer.pressure, self._clock()))

    async def _look_for_floor(self, traveller: _Traveller) -> None:
        """Ask the clone on which floor the robot leaves the car, until it answers or the answer is not needed."""
        machine, rider = traveller.machine, traveller.rider
        while machine.journey.looks_for_floor:
            journey = machine.journey
            try:
                parts = await self._hooks.parts(journey)
                request = floor_request(journey, self.layout, parts, rider.pose, self._clock())
                answer = await rider.find_floor(request)
            except (NotFound, Conflict, InvalidInput) as error:
                logger.info("robot %s believes the lift: %s", journey.robot, error)
                self._take(traveller, machine.cannot_look(self._clock()))
            except PPaaSError as error:
                logger.debug("robot %s is asked again where it is: %s", journey.robot, error)
                await asyncio.sleep(PAUSE)
            else:
                x, y, yaw = pose_of(answer.pose)
                found = machine.looked(answer.floor, answer.known, answer.probability, (x, y, yaw), self._clock())
                self._take(traveller, found)
                return

    async def _plan(self, traveller: _Traveller, number: int) -> None:
        machine = traveller.machine
        pose = traveller.rider.pose
        if pose is None or traveller.moving:
            raise Unavailable("it is not localized yet")
        try:
            legs = await self._hooks.plan(machine.journey, pose)
        except PPaaSError as error:
            self._take(traveller, machine.no_plan(number, str(error), self._clock()))
        else:
            self._take(traveller, machine.planned(number, legs, self._clock()))

    async def _store_ride(self, order: StoreRide | RemoveRide) -> None:
        if isinstance(order, StoreRide):
            before, self._rides[order.ride.robot] = self._rides.get(order.ride.robot), order.ride
            if before is not None and (before.phase, order.ride.phase) == ("waiting", "boarding"):
                self._hooks.waited(self._clock() - before.since)
        else:
            self._rides.pop(order.robot, None)
        await self._save()

    async def _save(self) -> None:
        async with self._saving:
            active = [journey for journey in self.journeys if journey.state == "active"]
            await self._hooks.keep(active, list(self._rides.values()))


def _view_of(journey: Journey) -> JourneyView:
    leg = journey.now.name if journey.leg < len(journey.legs) else ""
    return JourneyView(
        journey.id, journey.user, journey.robot, journey.on, journey.floor, journey.phase, leg, journey.state,
        journey.text, journey.since, journey.ended,
    )  # fmt: skip
