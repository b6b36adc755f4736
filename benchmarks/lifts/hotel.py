"""Hotel with lifts and robots that ride in them, simulated: the controller of lifts beside first-come-first-served.

Robots drive on a floor for a while, then ride to another floor. Lifts are simulated with their motion, doors and
sessions; robots pass the doors one by one.
"""

import random
from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Protocol

from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.lifts.controller import LiftController
from ppaas.buildings.lifts.simulated import LiftModel, SimulatedLift
from ppaas.buildings.lifts.states import (
    Alight,
    Board,
    EndSession,
    LiftOrder,
    LiftRequest,
    LiftState,
    Refuse,
)

STEP = 0.25
PASSAGE = 6.0
"""Time in which a robot passes the doors of a car [s]."""

DRIVE = (30.0, 90.0)
"""Shortest and longest time of a drive on a floor, before the next ride [s]."""

STOREY = 3.5


@dataclass(frozen=True, slots=True)
class Hotel:
    """Hotel, its robots and how long they are simulated.

    Parameters
    ----------
    robots, floors, lifts, capacity : int
        Numbers of robots, floors and lifts, and of robots that a car holds.
    seconds : float
    breaks_at : float
        Time at which the first lift goes out of order; infinite if none does.
    """

    robots: int = 20
    floors: int = 3
    lifts: int = 2
    capacity: int = 4
    seconds: float = 1800.0
    breaks_at: float = float("inf")

    @property
    def building(self) -> Building:
        """The building."""
        floors = tuple(
            Floor(name=f"L{level}", map=f"L{level}", elevation=STOREY * level) for level in range(self.floors)
        )
        lifts = tuple(LiftSettings(lift=f"lift {number}", robots=self.capacity) for number in range(self.lifts))
        return Building(floors=floors, lifts=lifts)


@dataclass(slots=True)
class LiftsResult:
    """What robots have done.

    Parameters
    ----------
    goals : int
        Number of rides that ended on the right floor.
    waits : list of float
        Times from requests to boarding [s].
    drives : list of float
        Times of drives between rides [s].
    longest_open : float
        Longest time from a request to the end of its ride, or of the simulation, but for robots in a broken car [s].
    boarded : Counter
        Largest number of robots that were in each lift at once.
    rerouted : float
        Time after a lift broke until no robot waits for it [s].
    """

    goals: int = 0
    waits: list[float] = field(default_factory=list)
    drives: list[float] = field(default_factory=list)
    longest_open: float = 0.0
    boarded: Counter[str] = field(default_factory=Counter)
    rerouted: float = 0.0


class LiftPolicy(Protocol):
    """Leads the robots of a building through its lifts."""

    def choose(self, origin: str, now: float) -> str:
        """Return the lift that a robot waits for."""
        ...

    def request(self, robot: str, lift: str, origin: str, destination: str, now: float) -> list[LiftOrder]:
        """Note a request."""
        ...

    def entered(self, robot: str, now: float) -> list[LiftOrder]:
        """Note that a robot is in the car."""
        ...

    def left(self, robot: str, now: float) -> list[LiftOrder]:
        """Note that a robot is out of the car."""
        ...

    def lift_state(self, state: LiftState, now: float) -> list[LiftOrder]:
        """Note a state."""
        ...

    def waiting(self, lift: str) -> int:
        """Return how many robots wait for a lift."""
        ...


class SharedLifts:
    """Our controller; robots wait for the lift that is estimated to be there first."""

    def __init__(self, hotel: Hotel) -> None:
        building = hotel.building
        stops = {lift.lift: [floor.name for floor in building.floors] for lift in building.lifts}
        self._controller = LiftController("hotel", building, stops, 0.0)
        self._lifts = list(stops)
        self.request = self._controller.request
        self.entered, self.left = self._controller.entered, self._controller.left
        self.lift_state = self._controller.lift_state

    def choose(self, origin: str, now: float) -> str:
        """Return the lift that is there first."""
        return min(self._lifts, key=lambda lift: self._controller.estimate(lift, origin, now))

    def waiting(self, lift: str) -> int:
        """Return how many robots wait for a lift."""
        return len(self._controller.cars[lift].waiting)


class FirstCome:
    """First come, first served: each lift serves the oldest request, one robot a trip; the shorter queue is chosen."""

    def __init__(self, hotel: Hotel) -> None:
        self._queues: dict[str, deque[tuple[str, str, str]]] = {
            lift.lift: deque() for lift in hotel.building.lifts
        }  # fmt: skip
        self._phase: dict[str, str] = dict.fromkeys(self._queues, "fetch")
        self._lift_of: dict[str, str] = {}
        self._asked: dict[str, float] = {}

    def choose(self, _origin: str, _now: float) -> str:
        """Return the lift with the shorter queue."""
        return min(self._queues, key=lambda lift: len(self._queues[lift]))

    def request(self, robot: str, lift: str, origin: str, destination: str, now: float) -> list[LiftOrder]:
        """Append to the queue."""
        self._queues[lift].append((robot, origin, destination))
        self._lift_of[robot] = lift
        return self._send(lift, now)

    def entered(self, robot: str, now: float) -> list[LiftOrder]:
        """Drive to its floor."""
        lift = self._lift_of[robot]
        self._phase[lift] = "bring"
        return self._send(lift, now)

    def left(self, robot: str, now: float) -> list[LiftOrder]:
        """Fetch the next one."""
        lift = self._lift_of[robot]
        self._queues[lift].popleft()
        self._phase[lift] = "fetch"
        return self._send(lift, now)

    def lift_state(self, state: LiftState, now: float) -> list[LiftOrder]:
        """Let the robot in or out where the doors stand open."""
        lift, queue = state.lift, self._queues[state.lift]
        if not queue:
            return [EndSession(lift, "first come")] if state.session else []
        robot, origin, destination = queue[0]
        is_open = state.door == "open" and state.motion == "stopped" and bool(state.session)
        if self._phase[lift] == "fetch" and is_open and state.floor == origin:
            self._phase[lift] = "passing in"
            return [Board(robot, lift, origin)]
        if self._phase[lift] == "bring" and is_open and state.floor == destination:
            self._phase[lift] = "passing out"
            return [Alight(robot, lift, destination)]
        return self._send(lift, now) if now - self._asked.get(lift, -1.0) >= 1.0 else []

    def waiting(self, lift: str) -> int:
        """Return how many robots wait for a lift, or are led through it."""
        return len(self._queues[lift])

    def _send(self, lift: str, now: float) -> list[LiftOrder]:
        if not self._queues[lift]:
            return []
        _, origin, destination = self._queues[lift][0]
        floor = destination if self._phase[lift] in ("bring", "passing out") else origin
        self._asked[lift] = now
        return [LiftRequest(lift, "first come", floor)]


@dataclass(slots=True)
class _Robot:
    name: str
    floor: str
    free_at: float
    destination: str = ""
    asked_at: float = 0.0
    passing: Board | Alight | None = None
    passed_at: float = 0.0


class HotelRun:
    """One run of a hotel.

    Parameters
    ----------
    hotel : Hotel
    policy : LiftPolicy
    seed : int
    """

    def __init__(self, hotel: Hotel, policy: LiftPolicy, seed: int) -> None:
        self._hotel, self._policy = hotel, policy
        self._random = random.Random(seed)
        levels = {floor.name: floor.elevation for floor in hotel.building.floors}
        self._floors = list(levels)
        self._lifts = {
            lift.lift: SimulatedLift(lift.lift, levels, 0.0, LiftModel(doors=lift.doors, speed=lift.speed))
            for lift in hotel.building.lifts
        }
        self._robots = {
            name: _Robot(name, self._random.choice(self._floors), self._random.uniform(0.0, DRIVE[1]))
            for name in (f"robot {number}" for number in range(hotel.robots))
        }
        self._inside: defaultdict[str, set[str]] = defaultdict(set)
        self.result = LiftsResult()

    def run(self) -> LiftsResult:
        """Simulate; return what robots have done."""
        for number in range(round(self._hotel.seconds / STEP)):
            self._step(number * STEP)
        end = self._hotel.seconds
        shut_in = self._inside[next(iter(self._lifts))] if self._hotel.breaks_at < end else ()
        still = [end - each.asked_at for each in self._robots.values() if each.destination and each.name not in shut_in]
        self.result.longest_open = max([self.result.longest_open, *still])
        return self.result

    def _step(self, now: float) -> None:
        for robot in self._robots.values():
            if robot.passing is not None and now >= robot.passed_at:
                self._pass(robot, now)
            elif not robot.destination and now >= robot.free_at:
                self._ask(robot, now)
        for name, lift in self._lifts.items():
            if self._hotel.breaks_at <= now < self._hotel.breaks_at + STEP and name == next(iter(self._lifts)):
                lift.set_mode("offline", now)
            self._obey(self._policy.lift_state(lift.state(now), now), now)
        if now > self._hotel.breaks_at and self._policy.waiting(next(iter(self._lifts))):
            self.result.rerouted = now - self._hotel.breaks_at

    def _ask(self, robot: _Robot, now: float) -> None:
        robot.destination = self._random.choice([floor for floor in self._floors if floor != robot.floor])
        robot.asked_at = now
        lift = self._policy.choose(robot.floor, now)
        self._obey(self._policy.request(robot.name, lift, robot.floor, robot.destination, now), now)

    def _pass(self, robot: _Robot, now: float) -> None:
        order, robot.passing = robot.passing, None
        assert order is not None
        inside = self._inside[order.lift]
        if isinstance(order, Board):
            inside.add(robot.name)
            self.result.boarded[order.lift] = max(self.result.boarded[order.lift], len(inside))
            self._obey(self._policy.entered(robot.name, now), now)
            return
        inside.discard(robot.name)
        self.result.goals += order.floor == robot.destination
        self.result.longest_open = max(self.result.longest_open, now - robot.asked_at)
        drive = self._random.uniform(*DRIVE)
        self.result.drives.append(drive)
        robot.floor, robot.destination, robot.free_at = order.floor, "", now + drive
        self._obey(self._policy.left(robot.name, now), now)

    def _obey(self, orders: Iterable[LiftOrder], now: float) -> None:
        for order in orders:
            match order:
                case LiftRequest():
                    self._lifts[order.lift].request(order, now)
                case EndSession():
                    self._lifts[order.lift].end(order, now)
                case Board() | Alight():
                    robot = self._robots[order.robot]
                    if isinstance(order, Board) and robot.passing is None:
                        self.result.waits.append(now - robot.asked_at)
                    robot.passing, robot.passed_at = order, now + PASSAGE
                case Refuse():
                    self._robots[order.robot].destination = ""
                    self._robots[order.robot].free_at = now


def simulate(hotel: Hotel, policy: Callable[[Hotel], LiftPolicy], seed: int) -> LiftsResult:
    """Run a hotel."""
    return HotelRun(hotel, policy(hotel), seed).run()
