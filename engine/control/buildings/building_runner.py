"""Lifts and doors of one building: their devices and controllers, and the orders that follow."""

import asyncio
import logging
from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import partial

from engine.control.buildings.held_device import HeldDevice
from engine.control.buildings.views import BuildingView, DoorView, LiftView, RideView
from engine.devices.hosts import DeviceHosts
from engine.devices.opening import open_door, open_lift
from ppaas.buildings.doors.controller import DoorController, DoorKey
from ppaas.buildings.doors.states import DoorAlert, DoorOrder, DoorRequest, DoorState, Pass
from ppaas.buildings.faults import FaultChange, FaultWatch, PartName
from ppaas.buildings.layout import BuildingLayout
from ppaas.buildings.lifts.attendant import MayLeave
from ppaas.buildings.lifts.controller import LiftController
from ppaas.buildings.lifts.schedule import levels_of
from ppaas.buildings.lifts.states import (
    Alight,
    Board,
    EndSession,
    LiftAlert,
    LiftOrder,
    LiftRequest,
    LiftRide,
    LiftState,
    Refuse,
    RemoveRide,
    StoreRide,
    Wait,
)
from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import PPaaSError

logger = logging.getLogger(__name__)

TICK = 0.25
"""Time between two looks at the time and at the connected robots [s]."""

STORE_PAUSE = 1.0
"""Pause before a record that could not be stored is stored again [s]."""

RobotOrder = Board | Alight | Pass | Wait | Refuse

BuildingAlert = LiftAlert | DoorAlert | FaultChange


@dataclass(frozen=True, slots=True)
class BuildingHooks:
    """What a building needs of the rest of the master.

    Parameters
    ----------
    obey : callable
        Called with each order to a robot, after the records on which it rests are stored.
    store : callable
        Stores or removes the record of a ride.
    connected : callable
        Returns the robots that are connected.
    alert : callable
        Called with what people must look at, and with lifts and doors that have a fault or serve again, after the log.
    may_leave : MayLeave
        Called with a lift and a floor; returns whether the lobby has room for a robot that leaves the car.
    """

    obey: Callable[[RobotOrder], None]
    store: Callable[[StoreRide | RemoveRide], Awaitable[None]]
    connected: Callable[[], Collection[str]]
    alert: Callable[[BuildingAlert], None] = lambda _alert: None
    may_leave: MayLeave = lambda _lift, _floor: True


def steady_epoch() -> Clock:
    """Return a clock of seconds since the epoch that does not jump when the computer's is set."""
    began, at = monotonic(), epoch()
    return lambda: at + monotonic() - began


class BuildingRunner:
    """Leads the lifts and doors of a building that have devices.

    Events of robots may come at any time; orders that follow from them go out while ``run`` runs.

    Parameters
    ----------
    name : str
        Name of the building in sessions of its devices: no other cloud or building has it.
    layout : BuildingLayout
    hooks : BuildingHooks
    hosts : DeviceHosts
        Hosts that devices may have.
    rides : iterable of LiftRide
        Stored rides.
    """

    def __init__(
        self,
        name: str,
        layout: BuildingLayout,
        hooks: BuildingHooks,
        hosts: DeviceHosts,
        *,
        rides: Iterable[LiftRide] = (),
        clock: Clock | None = None,
    ) -> None:
        self._hooks = hooks
        self._now = steady_epoch() if clock is None else clock
        self._faults: list[str] = []
        self._orders: asyncio.Queue[StoreRide | RemoveRide | RobotOrder | BuildingAlert] = asyncio.Queue()
        self._watch = FaultWatch()
        stops = {lift: [place.floor for place in places] for lift, places in layout.landings.items()}
        self._lift_devices = self._open_lifts(layout, stops, hosts)
        self._door_devices = self._open_doors(layout, hosts)
        self.lifts = LiftController(
            name,
            layout.building,
            {lift: stops[lift] for lift in self._lift_devices},
            self._now(),
            rides=rides,
            may_leave=hooks.may_leave,
        )
        self.doors = DoorController(name, self._door_devices)

    def _open_lifts(
        self, layout: BuildingLayout, stops: Mapping[str, Collection[str]], hosts: DeviceHosts
    ) -> dict[str, HeldDevice[LiftRequest | EndSession]]:
        levels, found = levels_of(layout.building), {}
        for lift, floors in stops.items():
            settings = layout.building.lift(lift)
            if settings.device:
                try:
                    device = open_lift(settings, {name: levels[name] for name in levels if name in floors}, hosts)
                except PPaaSError as error:
                    self._note_fault(f"lift {lift!r}: {error}")
                    continue
                found[lift] = HeldDevice(f"lift {lift!r}", partial(device.run, self._see_lift), device.send)
        return found

    def _open_doors(self, layout: BuildingLayout, hosts: DeviceHosts) -> dict[DoorKey, HeldDevice[DoorRequest]]:
        found = {}
        for place in layout.doors:
            settings = layout.building.door(place.floor, place.door)
            if settings.device and not place.lift:  # a lift moves the doors of its landings itself
                name = f"door {place.door!r} of floor {place.floor!r}"
                try:
                    device = open_door(settings, hosts)
                except PPaaSError as error:
                    self._note_fault(f"{name}: {error}")
                    continue
                found[place.floor, place.door] = HeldDevice(name, partial(device.run, self._see_door), device.send)
        return found

    def _note_fault(self, text: str) -> None:
        logger.warning("%s", text)
        self._faults.append(text)

    # -- events of robots ----------------------------------------------------------------------------------------------

    def request(self, robot: str, lift: str, origin: str, destination: str, *, size: int = 1) -> None:
        """Note that a robot wants to ride, as ``LiftController.request``."""
        self._take(self.lifts.request(robot, lift, origin, destination, self._now(), size=size))

    def entered(self, robot: str) -> None:
        """Note that a robot is in the car, clear of the doors."""
        self._take(self.lifts.entered(robot, self._now()))

    def left(self, robot: str) -> None:
        """Note that a robot is out of the car, clear of the doors."""
        self._take(self.lifts.left(robot, self._now()))

    def cancel(self, robot: str) -> None:
        """Note that a robot does not want to ride any more, as ``LiftController.cancel``."""
        self._take(self.lifts.cancel(robot, self._now()))

    def approach(self, robot: str, floor: str, door: str) -> None:
        """Note that a robot stands before a door, or nears it."""
        self._take(self.doors.approach(robot, floor, door, self._now()))

    def passed(self, robot: str, floor: str, door: str) -> None:
        """Note that a robot is clear of a door."""
        self._take(self.doors.passed(robot, floor, door, self._now()))

    # -- what is known -------------------------------------------------------------------------------------------------

    def waits(self) -> dict[tuple[str, str], float]:
        """Return about how long a robot would wait for each lift at each floor [s]; see ``LiftController.waits``."""
        return self.lifts.waits(self._now())

    @property
    def has_heard_all(self) -> bool:
        """Whether each lift and each door has reported a state."""
        return None not in {*(car.state for car in self.lifts.cars.values()), *self.doors.states.values()}

    def out_of_order(self) -> dict[str, str]:
        """Return the lifts that are out of order, each with what it reports."""
        now = self._now()
        return {lift: car.fault(now) for lift, car in self.lifts.cars.items() if car.is_out_of_order(now)}

    def view(self) -> BuildingView:
        """Return the state of lifts and doors."""
        return BuildingView(
            [self._lift_view(lift) for lift in self.lifts.cars],
            [
                DoorView(*key, "unknown" if state is None else state.mode, list(self.doors.robots_at(key)), fault)
                for (key, state), fault in zip(self.doors.states.items(), self._door_faults(), strict=True)
            ],
            list(self._faults),
        )

    def _lift_view(self, lift: str) -> LiftView:
        car = self.lifts.cars[lift]
        state = car.state or LiftState(lift=lift, mode="unknown")
        rides = [
            RideView(ride.robot, ride.origin, ride.destination, ride.phase, ride.since)
            for ride in sorted(car.rides.values(), key=lambda ride: ride.since)
        ]
        fault, target = car.fault(self._now()), self.lifts.target(lift)
        return LiftView(
            lift, fault, state.floor, target, state.door, state.motion, state.mode, state.session, rides,
            not car.disorder(self._now()),
        )  # fmt: skip

    def _door_faults(self) -> list[str]:
        return [self.doors.fault(key, self._now()) for key in self.doors.states]

    def _watch_faults(self) -> None:
        """Report lifts and doors that have a fault, and those that serve again."""
        now = self._now()
        lifts = {PartName("lift", lift): car.disorder(now) for lift, car in self.lifts.cars.items()}
        keys = (PartName("door", door, floor) for floor, door in self.doors.states)
        for change in self._watch.look({**lifts, **dict(zip(keys, self._door_faults(), strict=True))}, now):
            self._orders.put_nowait(change)

    # -- run -----------------------------------------------------------------------------------------------------------

    async def run(self) -> None:
        """Lead the devices until cancelled; sessions that nobody needs are ended then, others by their lifts."""
        try:
            async with asyncio.TaskGroup() as group:
                for lift in self._lift_devices.values():
                    group.create_task(lift.run())
                for door in self._door_devices.values():
                    group.create_task(door.run())
                group.create_task(self._obey())
                group.create_task(self._tick())
        finally:
            await asyncio.gather(*self._let_go())

    def _let_go(self) -> list[Awaitable[None]]:
        """Return the last orders to the devices in which no robot is; a door that had no order gets none."""
        idle = {lift: car for lift, car in self.lifts.cars.items() if not car.aboard}
        last = [self._lift_devices[lift].send_now(EndSession(lift, car.session)) for lift, car in idle.items()]
        doors = [key for key, state in self.doors.states.items() if state is not None and not self.doors.robots_at(key)]
        ordered = (key for key in doors if self._door_devices[key].was_ordered)
        return [*last, *(self._door_devices[key].send_now(self.doors.closing(key)) for key in ordered)]

    async def _tick(self) -> None:
        while True:
            robots = self._hooks.connected()
            self._take(self.lifts.robots_seen(robots, self._now()))
            self._take(self.doors.robots_seen(robots, self._now()))
            self._watch_faults()
            await asyncio.sleep(TICK)

    def _see_lift(self, state: LiftState) -> None:
        self._take(self.lifts.lift_state(state, self._now()))

    def _see_door(self, state: DoorState) -> None:
        self._take(self.doors.door_state(state, self._now()))

    def _take(self, orders: Iterable[LiftOrder | DoorOrder]) -> None:
        """Pass on orders: to devices at once, since their sessions end without them; others in turn."""
        for order in orders:
            if isinstance(order, LiftRequest | EndSession):
                self._lift_devices[order.lift].order(order)
            elif isinstance(order, DoorRequest):
                self._door_devices[order.floor, order.door].order(order)
            else:
                self._orders.put_nowait(order)

    async def _obey(self) -> None:
        while True:
            order = await self._orders.get()
            if isinstance(order, StoreRide | RemoveRide):
                await self._store(order)
            elif isinstance(order, LiftAlert | DoorAlert | FaultChange):
                logger.warning("%s", order.sentence if isinstance(order, FaultChange) else order.text)
                self._hooks.alert(order)
            else:
                self._hooks.obey(order)

    async def _store(self, order: StoreRide | RemoveRide) -> None:
        """Store a record, and again until it is stored: no robot moves on a ride that a restart would forget."""
        while True:
            try:
                await self._hooks.store(order)
            except PPaaSError as error:
                logger.warning("a ride is stored again, which failed: %s", error)
                await asyncio.sleep(STORE_PAUSE)
            else:
                return
