"""Controller of the lifts of a building, for all of its robots: events in, orders out.

What it knows of rides follows from their records, which are stored before the orders that follow from them. So a
controller that is made from the stored rides goes on where an earlier one was killed. Sessions that an earlier one left
open are ended if no ride needs them, for their names are the same.
"""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence

from msgspec.structs import replace

from ppaas.buildings.building import Building
from ppaas.buildings.lifts.attendant import Attendant, MayLeave
from ppaas.buildings.lifts.car import Car
from ppaas.buildings.lifts.schedule import AGED, ROBOT_TIME, Shaft, levels_of
from ppaas.buildings.lifts.states import LiftOrder, LiftRide, LiftState, Refuse, RemoveRide


class LiftController:
    """State machine of all lifts of a building. Its methods are events; they return orders, to be obeyed in turn.

    Parameters
    ----------
    owner : str
        Name of the building in sessions, which no other controller of its lifts has.
    building : Building
    lifts : mapping of str to collection of str
        Floors on which each lift stops, as the layout of the building has them.
    now : float
        Time [s since the epoch], as everywhere here.
    rides : iterable of LiftRide
        Stored rides; those of lifts that are no more are refused by ``tick``.
    may_leave : MayLeave
        Called to find out whether a lobby has room for a robot that leaves a car.
    aged : float
        Time after which a robot that waits is fetched before all others [s].
    """

    def __init__(
        self,
        owner: str,
        building: Building,
        lifts: Mapping[str, Collection[str]],
        now: float,
        *,
        rides: Iterable[LiftRide] = (),
        may_leave: MayLeave = lambda _lift, _floor: True,
        aged: float = AGED,
    ) -> None:
        levels = levels_of(building)
        self._cars: dict[str, Car] = {}
        for lift, floors in lifts.items():
            shaft = Shaft({name: levels[name] for name in levels if name in floors}, building.lift(lift), aged)
            self._cars[lift] = Car(shaft, f"ppaas/{owner}/{lift}", now)
        self._attendants = {lift: Attendant(car, may_leave) for lift, car in self._cars.items()}
        self._lift_of: dict[str, str] = {}
        self._orphans: list[LiftRide] = []
        for ride in _not_ahead(list(rides), now):
            if self._misfit(ride):
                self._orphans.append(ride)
            else:
                self._cars[ride.lift].put(ride, now)
                self._lift_of[ride.robot] = ride.lift

    @property
    def cars(self) -> Mapping[str, Car]:
        """Cars by lift: their states and rides."""
        return self._cars

    @property
    def rides(self) -> dict[str, LiftRide]:
        """Rides that have not ended, by robot."""
        return {robot: ride for car in self._cars.values() for robot, ride in car.rides.items()}

    def target(self, lift: str) -> str:
        """Return the floor to which a car is sent; empty if to none."""
        return self._attendants[lift].target

    # -- events of robots ----------------------------------------------------------------------------------------------

    def request(
        self, robot: str, lift: str, origin: str, destination: str, now: float, *, size: int = 1
    ) -> list[LiftOrder]:
        """Note that a robot wants to ride; it stands before the door, or in the car if it changes its destination.

        The same request again has its last order repeated. A robot that is aboard keeps its place and session, and
        gets another destination; if it cannot ride there in this lift, it leaves at the next floor.
        """
        before = self._ride(robot)
        if before is not None and before.is_aboard:
            return self._redirect(before, lift, destination, now)
        since = before.since if before is not None and before.lift == lift else now
        wanted = LiftRide(robot=robot, lift=lift, origin=origin, destination=destination, size=size, since=since)
        misfit = self._misfit(wanted)
        orders: list[LiftOrder] = (
            [] if before is None or (before.lift == lift and not misfit) else self._end(robot, now)
        )
        if misfit:
            return [*orders, Refuse(robot, misfit), *self.tick(now)]
        self._lift_of[robot] = lift
        orders += self._cars[lift].put(wanted, now)
        self._attendants[lift].forget(robot)
        return orders + self._attendants[lift].advance(now)

    def _redirect(self, ride: LiftRide, lift: str, destination: str, now: float) -> list[LiftOrder]:
        """Change the destination of a robot that is aboard."""
        if ride.phase != "alighting":
            wanted = replace(ride, destination=destination, goes=False)
            fits = lift == ride.lift and destination != ride.origin and not self._misfit(wanted)
            ride = wanted if fits else replace(ride, goes=True)
        orders = self._cars[ride.lift].put(ride, now)
        self._attendants[ride.lift].forget(ride.robot)
        return orders + self._advance(ride.lift, now)

    def entered(self, robot: str, now: float) -> list[LiftOrder]:
        """Note that a robot is in the car, clear of the doors."""
        ride = self._ride(robot)
        if ride is None or ride.phase in ("inside", "alighting"):
            return []
        return [*self._cars[ride.lift].put(replace(ride, phase="inside"), now), *self._advance(ride.lift, now)]

    def left(self, robot: str, now: float) -> list[LiftOrder]:
        """Note that a robot is out of the car, clear of the doors: its ride has ended."""
        ride = self._ride(robot)
        if ride is None:
            return []
        return [*self._end(robot, now), *self._advance(ride.lift, now)]

    def cancel(self, robot: str, now: float) -> list[LiftOrder]:
        """Note that a robot does not want to ride any more.

        A robot that waits is forgotten. One that boards is led out again, and one that is inside leaves at the next
        floor; ``left`` ends their rides.
        """
        ride = self._ride(robot)
        if ride is None:
            return []
        car = self._cars[ride.lift]
        match ride.phase:
            case "waiting":
                orders = self._end(robot, now)
            case "boarding":
                orders = car.put(replace(ride, phase="alighting", destination=ride.origin, goes=True), now)
            case _:
                orders = car.put(replace(ride, goes=True), now)
        return orders + self._advance(ride.lift, now)

    def robots_seen(self, robots: Collection[str], now: float) -> list[LiftOrder]:
        """Note the robots that are connected: all of them, each time."""
        for car in self._cars.values():
            car.see_robots(robots, now)
        return self.tick(now)

    # -- events of lifts, and time -------------------------------------------------------------------------------------

    def lift_state(self, state: LiftState, now: float) -> list[LiftOrder]:
        """Note what a lift reports."""
        if state.lift not in self._cars:
            return []
        self._cars[state.lift].see(state, now)
        return self._advance(state.lift, now)

    def tick(self, now: float) -> list[LiftOrder]:
        """Return what follows from the time; call it several times a second."""
        orders: list[LiftOrder] = []
        while self._orphans:
            ride = self._orphans.pop()
            orders += [RemoveRide(ride.robot), Refuse(ride.robot, self._misfit(ride))]
        for lift in self._cars:
            orders += self._advance(lift, now)
        return orders

    # -- what is known -------------------------------------------------------------------------------------------------

    def waits(self, now: float) -> dict[tuple[str, str], float]:
        """Return about how long a robot would wait for each lift at each floor [s]: all whose lifts are known."""
        known = (car for car in self._cars.values() if not car.is_new(now))
        return {(car.lift, floor): self.estimate(car.lift, floor, now) for car in known for floor in car.shaft.levels}

    def estimate(self, lift: str, origin: str, now: float) -> float:
        """Return about how long a robot would wait for a lift at a floor [s]; infinite if it does not serve robots."""
        car = self._cars.get(lift)
        if car is None or not car.serves(origin, now):
            return math.inf
        shaft, settings = car.shaft, car.shaft.settings
        ahead = list(car.rides.values())
        trips = math.ceil(sum(ride.size for ride in ahead) / settings.robots)
        mean = sum(shaft.seconds(ride.origin, ride.destination) for ride in ahead) / max(len(ahead), 1)
        taken = settings.wait if car.is_taken() else 0.0
        return taken + trips * mean + 2.0 * ROBOT_TIME * len(ahead) + shaft.seconds(car.at, origin)

    # -- internals -----------------------------------------------------------------------------------------------------

    def _ride(self, robot: str) -> LiftRide | None:
        car = self._cars.get(self._lift_of.get(robot, ""))
        return None if car is None else car.rides.get(robot)

    def _advance(self, lift: str, now: float) -> list[LiftOrder]:
        return self._attendants[lift].advance(now)

    def _end(self, robot: str, now: float) -> list[LiftOrder]:
        return self._cars[self._lift_of.pop(robot)].end(robot, now)

    def _misfit(self, ride: LiftRide) -> str:
        """Return why a lift can never serve a ride; empty if it can."""
        car = self._cars.get(ride.lift)
        if car is None:
            return f"lift {ride.lift!r} has no device that sends it; lifts with one: {', '.join(self._cars) or 'none'}"
        stops = car.shaft.levels if car.state is None or not car.state.floors else car.state.floors
        for floor in (ride.origin, ride.destination):
            if floor not in car.shaft.levels or floor not in stops:
                return f"lift {ride.lift!r} does not stop on floor {floor!r}; it stops on {', '.join(stops)}"
        if ride.origin == ride.destination and not ride.is_aboard:
            return f"robot {ride.robot!r} is on floor {ride.origin!r} already"
        if not 1 <= ride.size <= car.shaft.settings.robots:
            return f"lift {ride.lift!r} has room for {car.shaft.settings.robots} robots, not {ride.size}"
        return ""


def _not_ahead(rides: Sequence[LiftRide], now: float) -> list[LiftRide]:
    """Return stored rides, all of them earlier if the clock of the computer that stored them was ahead."""
    ahead = max((ride.since - now for ride in rides), default=0.0)
    return [replace(ride, since=ride.since - ahead) for ride in rides] if ahead > 0.0 else list(rides)
