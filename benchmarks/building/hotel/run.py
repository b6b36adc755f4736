"""Run of a house: robots on journeys, led by the site of the building, in simulated time."""

import asyncio
import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from random import Random

import numpy as np

from benchmarks.building.hotel.floor import FloorTraffic
from benchmarks.building.hotel.house import RADIUS, House
from benchmarks.building.hotel.robot import HotelRobot
from benchmarks.building.hotel.virtual_time import run_in_virtual_time
from benchmarks.fleet.stand_ins.robot import PERIOD, StandIn
from benchmarks.harness.halls import largest_part
from engine.control.journeys.kept import KeptJourneys
from engine.control.journeys.site import JourneySite, SiteHooks
from engine.control.views import GoalView
from engine.devices.hosts import DeviceHosts
from ppaas.buildings.journeys.records import Journey, JourneyLeg
from ppaas.buildings.layout import Landing, Place
from ppaas.buildings.lifts.controller import LiftController
from ppaas.buildings.lifts.states import LiftRide
from ppaas.buildings.planning.legs import legs_of
from ppaas.buildings.planning.times import Traveller
from ppaas.buildings.riding.car_frame import carried, is_inside
from ppaas.errors import NoValidPath
from ppaas.geometry import Pose2D
from ppaas.messages.fleet.floors import FloorPart

SPEED = 0.5
"""Speed of robots [m/s]."""

BESIDE_LIFTS = 4.0
"""Least distance of goals from the places where robots wait for lifts [m]."""

SPREAD = 30.0
"""Time within which robots get their first goals [s]."""

FAR_FROM_CAR = 4.0
"""Distance from the middle of a car from which no robot is in it [m]."""

DEADLOCK = 60.0
"""Time in which no robot gets on from which it counts as a deadlock [s]."""

LOOK = 0.2
"""Time between two looks at contacts and doors [s]."""


@dataclass(frozen=True)
class HotelCase:
    """House, its robots and how long they are simulated.

    Parameters
    ----------
    house : House
        Without devices.
    robots, capacity : int
        Number of robots, and of those that a car holds.
    seconds : float
    breaks_at : float
        Time at which the first lift goes out of order [s]; infinite if none does.
    first_come : bool
        Whether lifts serve one robot a trip, in the order of requests.
    """

    house: House
    robots: int = 20
    capacity: int = 2
    seconds: float = 1800.0
    breaks_at: float = math.inf
    first_come: bool = False


@dataclass(slots=True)
class HotelResult:
    """What robots have done.

    Parameters
    ----------
    goals : int
        Number of goals that were reached.
    failed : list of str
        Robots whose goals ended otherwise, and why.
    waits, drives, rides : list of float
        Times from requests of lifts to boarding, of drives before and after a ride, and from boarding until the robot
        is out [s].
    passages : mapping of str to list of float
        Times of boarding and of alighting [s].
    aboard : int
        Largest number of robots in a car.
    contacts, shut : int
        Times that two robots touched, and that a robot was in a door of a lift that did not stand open there.
    nearest : float
        Smallest gap between two robots [m].
    longest : float
        Longest time for which a goal was open [s].
    rerouted : float
        Time after a lift broke until no robot waits for it, or is on its way to it [s].
    stood : float
        Longest time in which no robot got on, although goals were open [s].
    deadlocks : int
        Number of times that this was `DEADLOCK`.
    """

    goals: int = 0
    failed: list[str] = field(default_factory=list)
    waits: list[float] = field(default_factory=list)
    drives: list[float] = field(default_factory=list)
    rides: list[float] = field(default_factory=list)
    passages: defaultdict[str, list[float]] = field(default_factory=lambda: defaultdict(list))
    aboard: int = 0
    contacts: int = 0
    shut: int = 0
    nearest: float = math.inf
    longest: float = 0.0
    rerouted: float = 0.0
    stood: float = 0.0
    deadlocks: int = 0


@dataclass(slots=True)
class _Times:
    """Times of a robot: since when its goal is open and it is in a phase, when it boarded, and how long it drove."""

    goal: float
    phase: str = ""
    since: float = 0.0
    ride: float = 0.0
    drove: float = 0.0


class HouseRun:
    """One run.

    Parameters
    ----------
    case : HotelCase
    seed : int
    """

    def __init__(self, case: HotelCase, seed: int) -> None:
        capacity = 1 if case.first_come else case.capacity
        first = next(iter(case.house.layout.landings), "")
        options = {first: f"?breaks={case.breaks_at}"} if case.breaks_at < case.seconds else {}
        self.house = case.house.with_devices(capacity, options)
        self._case, self._first, self._rng = case, first, Random(seed)
        self.floors = {
            name: FloorTraffic(layers, self.house.planner.floors[number].paths, self._rng)
            for number, (name, layers) in enumerate(self.house.layers.items())
        }
        landings = [each for places in self.house.layout.landings.values() for each in places]
        self._landings = {name: [each for each in landings if each.floor == name] for name in self.floors}
        self._places = {name: self._cells(name) for name in self.floors}
        self.robots: dict[str, HotelRobot] = {}
        self.journeys: dict[str, Journey] = {}
        self._times: dict[str, _Times] = {}
        self._touching: set[frozenset[str]] = set()
        self._shut: set[str] = set()
        self._count, self._got_on = 0, 0.0
        self.result = HotelResult()

    def run(self, watch: Callable[["HouseRun", float], None] = lambda _run, _now: None) -> HotelResult:
        """Simulate; return what robots have done. ``watch`` is called after each control cycle."""
        run_in_virtual_time(self._run(watch))
        return self.result

    async def _run(self, watch: Callable[["HouseRun", float], None]) -> None:
        clock = asyncio.get_running_loop().time
        hooks = SiteHooks(self._rider, self._plan, self._keep, self._changed, self._parts)
        self.site = JourneySite("hotel", self.house.layout, hooks, DeviceHosts(), kept=KeptJourneys(), clock=clock)
        if self._case.first_come:
            runner, layout = self.site.runner, self.house.layout
            stops = {lift: [each.floor for each in places] for lift, places in layout.landings.items()}
            runner.lifts = LiftController("hotel", layout.building, stops, clock(), aged=0.0)
        self._put_robots()
        running = asyncio.create_task(self.site.run())
        due = 0.0
        while (now := clock()) < self._case.seconds:
            self._hand_out(now)
            for floor in self.floors.values():
                floor.step(now, self._moved)
            if now >= due:
                due = now + LOOK
                self._look(now)
            watch(self, now)
            await asyncio.sleep(PERIOD)
        open_for = [clock() - times.goal for name, times in self._times.items() if self._counts(name)]
        self.result.longest = max([self.result.longest, *open_for])
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)

    def _counts(self, name: str) -> bool:
        journey = self.journeys.get(name)
        return journey is not None and journey.state == "active" and not self._is_shut_in(journey)

    def _is_shut_in(self, journey: Journey) -> bool:
        """Return whether a robot is in the car that has broken."""
        broken = asyncio.get_running_loop().time() > self._case.breaks_at
        return broken and journey.is_aboard and journey.now.name == self._first

    # -- robots and goals ----------------------------------------------------------------------------------------------

    def _cells(self, floor: str) -> list[tuple[float, float]]:
        """Return the places of goals on a floor: cells that are connected, and not before lifts or in their cars."""
        roadmap = self.floors[floor].roadmap
        places = [roadmap.centre(cell) for cell in largest_part(roadmap.roadmap)]
        waits = [each.wait[:2] for each in self._landings[floor]]
        return [place for place in places if all(math.dist(place, wait) > BESIDE_LIFTS for wait in waits)]

    def _put_robots(self) -> None:
        names = list(self.floors)
        taken = {name: self._rng.sample(self._places[name], len(self._places[name])) for name in names}
        for number in range(self._case.robots):
            floor = names[number % len(names)]
            place = taken[floor].pop()
            name = f"robot {number + 1}"
            self.robots[name] = HotelRobot(name, self.house.building, self.floors, floor, Pose2D(*place, 0.0))
            self._times[name] = _Times(self._rng.uniform(0.0, SPREAD))

    def _hand_out(self, now: float) -> None:
        """Send robots that have no goal to places on other floors, if there are any."""
        for name, robot in self.robots.items():
            journey, times = self.journeys.get(name), self._times[name]
            if now < times.goal or (journey is not None and journey.state == "active"):
                continue
            self._count += 1
            floor = self._rng.choice([each for each in self.floors if each != robot.floor] or list(self.floors))
            goal = (*self._rng.choice(self._places[floor]), 0.0)
            times.goal, times.drove, times.since, times.phase = now, 0.0, now, ""
            self.site.begin(
                Journey(
                    id=f"goal-{self._count}", user="ann", robot=name, building="hotel", floor=floor, goal=goal,
                    on=robot.floor, since=now,
                )
            )  # fmt: skip

    # -- hooks of the site ---------------------------------------------------------------------------------------------

    def _rider(self, journey: Journey, ended: Callable[[GoalView], None]) -> HotelRobot:
        robot = self.robots[journey.robot]
        robot.ended = ended
        return robot

    async def _plan(self, journey: Journey, pose: Place) -> list[JourneyLeg]:
        planner = self.house.planner
        planner.state.expect(self.site.runner.waits())
        times = planner.times(Traveller(speed=SPEED, avoid=frozenset(journey.avoid)))
        found = planner.plan(times, (journey.on, pose[0], pose[1]), (journey.floor, *journey.goal[:2]))
        if found is None:
            raise NoValidPath("there is no route")
        return [
            JourneyLeg(
                kind=leg.kind, floor=leg.floor, to_floor=leg.to_floor, start=leg.start, goal=leg.goal,
                length=leg.length, name=leg.name,
            )
            for leg in legs_of(times, found.route, found.goal, (pose, journey.goal))
        ]  # fmt: skip

    async def _keep(self, _journeys: Sequence[Journey], _rides: Sequence[LiftRide]) -> None:
        """Keep nothing: no process is killed here."""

    async def _parts(self, _journey: Journey) -> dict[str, FloorPart]:
        """Return no parts of maps: robots have no scans, and believe the lift."""
        return {}

    def _changed(self, journey: Journey) -> None:
        name, now = journey.robot, asyncio.get_running_loop().time()
        before, self.journeys[name] = self.journeys.get(name), journey
        times = self._times[name]
        if before is not None and before.state != "active" and before.id == journey.id:
            return
        phase = "waiting for a lift" if journey.phase == "waiting" and journey.now.kind == "lift" else journey.phase
        if phase != times.phase or journey.state != "active":
            self._note_phase(times, phase, now)
            self._got_on = now
        if journey.state != "active":
            self.result.drives.append(times.drove)
            self.result.longest = max(self.result.longest, now - times.goal)
            if journey.state == "succeeded":
                self.result.goals += 1
            else:
                self.result.failed.append(f"{name}: {journey.state}, {journey.text}")
            times.goal = now

    def _note_phase(self, times: _Times, phase: str, now: float) -> None:
        spent, result = now - times.since, self.result
        match times.phase:
            case "driving" | "crossing" | "planning" | "waiting":
                times.drove += spent
            case "waiting for a lift" if phase == "boarding":
                result.waits.append(spent)
            case "boarding" | "alighting":
                result.passages[times.phase].append(spent)
        if phase == "boarding":
            times.ride = now
        if times.phase == "alighting":
            result.rides.append(now - times.ride)
        times.phase, times.since = phase, now

    # -- what is measured ----------------------------------------------------------------------------------------------

    def _moved(self, disc: StandIn) -> None:
        self.robots[disc.name].note()

    def _look(self, now: float) -> None:
        self._look_at_contacts()
        self._look_at_doors()
        drives = any(disc.gets_on for floor in self.floors.values() for disc in floor.robots.values())
        if drives or not any(map(self._counts, self.robots)):
            self._got_on = now
        stood = now - self._got_on
        self.result.deadlocks += self.result.stood < DEADLOCK <= stood
        self.result.stood = max(self.result.stood, stood)
        cars = self.site.runner.lifts.cars
        self.result.aboard = max(
            [self.result.aboard, *(sum(r.is_aboard for r in car.rides.values()) for car in cars.values())]
        )
        if now > self._case.breaks_at and any(self._is_led_to(journey) for journey in self.journeys.values()):
            self.result.rerouted = now - self._case.breaks_at

    def _is_led_to(self, journey: Journey) -> bool:
        """Return whether a robot is still to take the lift that has broken, or waits for it."""
        ahead = journey.legs[journey.leg :] if journey.state == "active" and not journey.is_aboard else ()
        return any(leg.name == self._first for leg in ahead)

    def _spot(self, robot: HotelRobot) -> tuple[str, float, float] | None:
        """Return where a robot is: floor or lift, and its place there; those in one car share its frame."""
        if robot.disc is None:
            return None
        pose = robot.disc.pose
        for landing in self._landings[robot.floor]:
            if math.dist(pose[:2], landing.car[:2]) < FAR_FROM_CAR and is_inside(landing, pose):
                first = self.house.layout.landings[landing.lift][0]
                at = carried(self.house.building, landing, first, pose)
                return landing.lift, at.x, at.y
        return robot.floor, pose.x, pose.y

    def _look_at_contacts(self) -> None:
        places = defaultdict[str, dict[str, tuple[float, float]]](dict)
        for robot in self.robots.values():
            spot = self._spot(robot)
            if spot is not None:
                places[spot[0]][robot.name] = spot[1:]
        touching = set[frozenset[str]]()
        for group in places.values():
            names, at = list(group), np.array(list(group.values()))
            gaps = np.hypot(*(at[:, None] - at[None]).transpose(2, 0, 1)) - 2.0 * RADIUS
            gaps[np.tril_indices(len(names))] = math.inf
            self.result.nearest = min(self.result.nearest, float(gaps.min()))
            touching |= {frozenset((names[one], names[other])) for one, other in np.argwhere(gaps <= 0.0)}
        self.result.contacts += len(touching - self._touching)
        self._touching = touching

    def _look_at_doors(self) -> None:
        """Count the robots that are in a door of a lift which does not stand open there."""
        shut = set[str]()
        for landing in (each for landings in self._landings.values() for each in landings):
            state = self.site.runner.lifts.cars[landing.lift].state
            is_open = state is not None and state.floor == landing.floor and state.door == "open"
            if not is_open:
                shut |= {name for name, disc in self.floors[landing.floor].robots.items() if _is_in_door(landing, disc)}
        self.result.shut += len(shut - self._shut)
        self._shut = shut


def _is_in_door(landing: Landing, disc: StandIn) -> bool:
    (x0, y0), (x1, y1) = landing.door.ends
    length = math.dist((x0, y0), (x1, y1))
    along = ((disc.pose.x - x0) * (x1 - x0) + (disc.pose.y - y0) * (y1 - y0)) / length
    across = abs((disc.pose.x - x0) * (y1 - y0) - (disc.pose.y - y0) * (x1 - x0)) / length
    return 0.0 < along < length and across < disc.radius
