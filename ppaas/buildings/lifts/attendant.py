"""Attendant of a car: leads robots through its doors one by one, sends it to floors, and lets it go."""

from collections.abc import Callable

from msgspec.structs import replace

from ppaas.buildings.lifts.car import Car
from ppaas.buildings.lifts.schedule import CarStop, heading, is_any_aged, next_stop
from ppaas.buildings.lifts.states import (
    Alight,
    Board,
    EndSession,
    LiftAlert,
    LiftOrder,
    LiftRequest,
    LiftRide,
    Phase,
    Refuse,
    Wait,
)

MayLeave = Callable[[str, str], bool]
"""Called with a lift and a floor; returns whether the lobby there has room for a robot that leaves the car."""

HEARTBEAT = 1.0
"""Time between two requests of a session, or two ends of one that the lift still has [s]."""

GONE = 8.0
"""Time after which a robot that waits and is not connected loses its place in the queue [s]."""

NO_RADIO = 90.0
"""Time for which a robot in the car or its doorway may be silent [s]: there is no radio in many cars."""

OUT_OF_ORDER, UNHEARD = 2.0, 10.0
"""Time after which robots do not wait any more for a lift that is out of order, or silent [s]."""

NO_PROGRESS, TAKEN = 60.0, 180.0
"""Time without progress after which robots that wait are refused, and for as long as people have the lift [s]."""

PATIENCE = 600.0
"""Longest time for which a robot waits in any case [s]."""

STUCK = 30.0
"""Time in a doorway after which people are called [s]."""

BLOCKED = 15.0
"""Time for which a robot in the car waits for room in the lobby until robots in the lobby make way [s]."""

STRANDED = 90.0
"""Time without progress after which robots leave a car that stands open at another floor [s]."""


class Attendant:
    """State machine of one car.

    Parameters
    ----------
    car : Car
        Its events are noted before ``advance``.
    may_leave : MayLeave
    """

    def __init__(self, car: Car, may_leave: MayLeave) -> None:
        self._car, self._may_leave = car, may_leave
        self._told: dict[str, Board | Alight | Wait] = {}
        self._alerted: set[str] = set()
        self._target: CarStop | None = None
        self._asked: LiftRequest | None = None
        self._sent_at = float("-inf")
        self._blocked: float | None = None
        self._may_hold = True

    @property
    def target(self) -> str:
        """Floor to which the car is sent; empty if to none."""
        return "" if self._target is None else self._target.floor

    def forget(self, robot: str) -> None:
        """Forget what a robot was ordered, so that it is ordered again."""
        self._told.pop(robot, None)

    def advance(self, now: float) -> list[LiftOrder]:
        """Return the orders that follow from the events of the car."""
        car = self._car
        orders = [*self._give_up(now), *self._retake(now)]
        if car.is_unsafe(now):
            orders += self._evacuate(now)
            self._target = None
        elif car.is_held(now):
            orders += self._serve(now)
        else:
            orders += self._wait_for_lift(now)
        for robot in (self._told.keys() | self._alerted) - car.rides.keys():
            self._told.pop(robot, None)
            self._alerted.discard(robot)
        return orders + self._ask(now)

    # -- ends and faults -----------------------------------------------------------------------------------------------

    def _give_up(self, now: float) -> list[LiftOrder]:
        """End the rides that cannot be, each with its reason."""
        orders: list[LiftOrder] = []
        for ride in tuple(self._car.rides.values()):
            reason = self._reason_to_end(ride, now)
            if reason:
                if ride.is_aboard:
                    orders += self._alert(ride.robot, reason)
                orders += [*self._car.end(ride.robot, now), Refuse(ride.robot, reason)]
        return orders

    def _reason_to_end(self, ride: LiftRide, now: float) -> str:
        car = self._car
        since = max(ride.since, car.times.began)  # the clock of the computer that stored it may be apart
        lost = now - car.times.lost.get(ride.robot, now)
        if ride.is_aboard:
            where = "the door" if ride.is_in_doorway else "the car"
            text = f"robot {ride.robot!r} is silent in {where} of lift {car.lift!r} for {lost:.0f} s"
            return text if lost > NO_RADIO else ""
        if lost > GONE:
            return f"robot {ride.robot!r} is not connected any more"
        if car.is_out_of_order(now) and now - max(car.times.mode, since) > OUT_OF_ORDER:
            return car.fault(now)
        if now - max(car.times.heard, since) > UNHEARD:
            return car.fault(now)
        waits = now - max(car.times.progress, since)
        if waits > (TAKEN if car.is_taken() else NO_PROGRESS):
            return car.fault(now) or self._obstacle(ride)
        return f"lift {car.lift!r} has not come for {PATIENCE:.0f} s" if now - since > PATIENCE else ""

    def _obstacle(self, ride: LiftRide) -> str:
        car = self._car
        if car.in_doorway:
            return f"robot {car.in_doorway[0].robot!r} stands in the door of lift {car.lift!r}"
        if not self._may_leave(car.lift, ride.destination):
            return f"the lobby of lift {car.lift!r} on floor {ride.destination!r} is taken"
        return f"lift {car.lift!r} does not come"

    def _retake(self, now: float) -> list[LiftOrder]:
        """Note where robots are whose doorway the car has left: in the queue, or still in the car."""
        orders: list[LiftOrder] = []
        car, state = self._car, self._car.state
        for ride in car.in_doorway:
            if state is None or car.is_silent(now) or state.door != "closed":
                continue
            if state.motion != "stopped" or state.floor != _doorway_of(ride):
                phase: Phase = "waiting" if ride.phase == "boarding" else "inside"
                orders += car.put(replace(ride, phase=phase), now)
        return orders

    def _evacuate(self, now: float) -> list[LiftOrder]:
        """Lead robots out where the doors stand open; nobody boards."""
        orders: list[LiftOrder] = []
        floor = self._car.open_at(now)
        reason = self._car.fault(now)
        for ride in tuple(self._car.rides.values()):
            if floor and ride.is_aboard:
                out = replace(ride, phase="alighting", destination=floor, goes=True)
                orders += [*self._car.put(out, now), *self._tell(Alight(ride.robot, self._car.lift, floor))]
            else:
                orders += self._tell(Wait(ride.robot, reason))
        return orders

    def _wait_for_lift(self, now: float) -> list[LiftOrder]:
        """Ask for a lift that others have, or that is silent; robots in its doorway go on only outwards."""
        car, reason = self._car, self._car.fault(now) or f"lift {self._car.lift!r} is called"
        passing = car.in_doorway
        if passing:
            self._target = CarStop(_doorway_of(passing[0]))
        else:
            self._plan(now)
        orders: list[LiftOrder] = []
        for ride in car.rides.values():
            is_open = car.state is not None and car.state.door == "open"
            if ride.phase != "alighting" or not is_open:
                orders += self._tell(Wait(ride.robot, reason, clear=ride.phase == "boarding"))
            orders += self._look_at_doorway(ride, now)
        return orders

    # -- stops ---------------------------------------------------------------------------------------------------------

    def _serve(self, now: float) -> list[LiftOrder]:
        """Lead robots through the doors one by one, those that leave first; then send the car on."""
        car = self._car
        assert car.state is not None, "a lift that is silent is not held"
        floor = car.open_at(now)
        if car.in_doorway:
            self._target = CarStop(_doorway_of(car.in_doorway[0]))
            return [order for ride in car.in_doorway for order in self._pass(ride, floor, now)]
        if not floor:
            is_elsewhere = car.state.motion == "stopped" and car.state.floor != self.target
            if is_elsewhere or not self._is_needed():
                self._plan(now)
            return self._tell_waiting()
        leaving = self._leaving(floor, now)
        if leaving and not self._may_leave(car.lift, floor):
            return self._wait_for_lobby(leaving, floor, now)
        self._blocked = None
        if leaving:
            return self._let_out(leaving[0], floor, now)
        entering = self._entering(floor, now)
        if entering is not None:
            return self._let_in(entering, floor, now)
        self._plan(now)
        return self._tell_waiting()

    def _pass(self, ride: LiftRide, floor: str, now: float) -> list[LiftOrder]:
        """Lead on a robot in the doorway, for which the doors stay open."""
        orders = self._look_at_doorway(ride, now)
        if floor != _doorway_of(ride):
            return orders + self._tell(Wait(ride.robot, f"the doors of lift {self._car.lift!r} are not open"))
        if ride.phase == "boarding":
            return orders + self._tell(Board(ride.robot, self._car.lift, floor, ride.place))
        return orders + self._tell(Alight(ride.robot, self._car.lift, floor))

    def _look_at_doorway(self, ride: LiftRide, now: float) -> list[LiftOrder]:
        if now - self._car.times.doorway.get(ride.robot, now) <= STUCK:
            return []
        return self._alert(ride.robot, f"robot {ride.robot!r} stands in the door of lift {self._car.lift!r}")

    def _leaving(self, floor: str, now: float) -> list[LiftRide]:
        is_stranded = now - self._car.times.progress > STRANDED
        return [ride for ride in self._car.inside if ride.destination == floor or ride.goes or is_stranded]

    def _let_out(self, ride: LiftRide, floor: str, now: float) -> list[LiftOrder]:
        out = replace(ride, phase="alighting", destination=floor)
        self._target = CarStop(floor)
        return [*self._car.put(out, now), *self._tell(Alight(ride.robot, self._car.lift, floor))]

    def _let_in(self, ride: LiftRide, floor: str, now: float) -> list[LiftOrder]:
        self._target = CarStop(floor)
        place = self._car.free_place(ride.size)
        boarding = self._car.put(replace(ride, phase="boarding", place=place), now)
        return [*boarding, *self._tell(Board(ride.robot, self._car.lift, floor, place))]

    def _wait_for_lobby(self, leaving: list[LiftRide], floor: str, now: float) -> list[LiftOrder]:
        """Wait for room in the lobby; after a while robots that wait there board first, or make way."""
        self._target = CarStop(floor)
        self._blocked = now if self._blocked is None else self._blocked
        orders: list[LiftOrder] = []
        for ride in leaving:
            orders += self._tell(Wait(ride.robot, f"the lobby of floor {floor!r} is taken"))
        if now - self._blocked <= BLOCKED:
            return orders
        entering = self._entering(floor, now)
        if entering is not None:
            return orders + self._let_in(entering, floor, now)
        for ride in self._car.waiting:
            if ride.origin == floor:
                orders += self._tell(Wait(ride.robot, "robots leave the lift here", clear=True))
        return orders

    def _entering(self, floor: str, now: float) -> LiftRide | None:
        """Return the next robot that boards: in the direction of those in the car, and if there is room for it."""
        shaft, ready = self._car.shaft, self._ready()
        here = [ride for ride in ready if ride.origin == floor]
        direction = heading(shaft, floor, self._car.aboard)
        if not direction:
            stop = next_stop(shaft, floor, (), ready if is_any_aged(shaft, ready, now) else here, now)
            direction = 0 if stop is None or stop.floor != floor else stop.direction
        room = shaft.settings.robots - sum(ride.size for ride in self._car.aboard)
        return next(iter(shaft.batch((ride for ride in here if shaft.direction(ride) == direction), room)), None)

    # -- where the car drives ------------------------------------------------------------------------------------------

    def _ready(self) -> list[LiftRide]:
        """Return the rides of robots that wait and can leave where they ride."""
        lift = self._car.lift
        return [ride for ride in self._car.waiting if self._may_leave(lift, ride.destination)]

    def _plan(self, now: float) -> None:
        at = self._car.at
        riders = [replace(ride, destination=at) if ride.goes else ride for ride in self._car.inside]
        self._target = next_stop(self._car.shaft, at, riders, self._ready(), now)

    def _is_needed(self) -> bool:
        """Return whether somebody boards or leaves at the floor to which the car drives."""
        return any(ride.destination == self.target or ride.goes for ride in self._car.inside) or any(
            ride.origin == self.target for ride in self._ready()
        )

    def _ask(self, now: float) -> list[LiftOrder]:
        """Repeat the request of the session; end it if nobody needs the lift, or it is silent and nobody is in it."""
        car = self._car
        if self._target is None or (car.is_silent(now) and not car.aboard):
            return self._release(now)
        request = LiftRequest(car.lift, car.session, self._target.floor)
        if request == self._asked and now - self._sent_at < HEARTBEAT:
            return []
        self._asked, self._sent_at, self._may_hold = request, now, True
        return [request]

    def _release(self, now: float) -> list[LiftOrder]:
        state = self._car.state
        still = state is not None and state.session == self._car.session and now - self._sent_at >= HEARTBEAT
        if not (self._may_hold or still):
            return []
        self._asked, self._sent_at, self._may_hold = None, now, False
        self._car.let_go()
        return [EndSession(self._car.lift, self._car.session)]

    # -- orders to robots ----------------------------------------------------------------------------------------------

    def _tell_waiting(self) -> list[LiftOrder]:
        orders: list[LiftOrder] = []
        for ride in self._car.waiting:
            orders += self._tell(Wait(ride.robot, f"lift {self._car.lift!r} is called"))
        return orders

    def _tell(self, order: Board | Alight | Wait) -> list[LiftOrder]:
        """Return an order, unless the robot was given the same one."""
        if self._told.get(order.robot) == order:
            return []
        self._told[order.robot] = order
        return [order]

    def _alert(self, robot: str, text: str) -> list[LiftOrder]:
        """Return a call for people, once for each ride."""
        if robot in self._alerted:
            return []
        self._alerted.add(robot)
        return [LiftAlert(self._car.lift, robot, text)]


def _doorway_of(ride: LiftRide) -> str:
    """Return the floor at whose door a robot boards or leaves."""
    return ride.origin if ride.phase == "boarding" else ride.destination
