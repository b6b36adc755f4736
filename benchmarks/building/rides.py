"""Rides of robots in lifts: is the floor known afterwards, and how soon is the robot localized there?

Each ride is in a building that is made up: floors that share lift and lobby, with other rooms, and furniture that the
maps don't show. The robot enters the car with an error of its pose, rides, and leaves on a floor that is at times not
the one it was sent to. Lifts say where they are, say nothing, or are wrong; half of the robots have a barometer.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from ppaas.buildings.building import Building, Floor
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.buildings.riding.air import GAS
from ppaas.buildings.riding.car_frame import carried
from ppaas.buildings.riding.floor_maps import clear_of, part_around
from ppaas.buildings.riding.floor_search import FloorSearch
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.localization.parameters import AmclParameters
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.maps.raycast import cast_rays
from ppaas.messages.fleet.floors import FindFloorRequest
from ppaas.messages.geometry_msgs import Pose
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet

FLOORS, STOREY = 5, 3.6
"""Number of floors, and the height between two of them [m]."""

WIDTH, DEPTH, RESOLUTION = 14.0, 10.0, 0.05
CAR = 6.2, 0.4, 7.8, 2.2
"""Least x and y and greatest x and y of the car, in the frame of the building [m]; its door is in the upper wall."""

SILENT, LIES, WRONG, BAROMETER = 0.3, 0.05, 0.05, 0.5
"""Shares of lifts that say nothing, of those that name a wrong floor, of rides that end on another floor, and of robots
with a barometer."""

RIDE, AIR = 40.0, 0.5
"""Duration of a ride [s], and by how much the pressure of the air drifts meanwhile: standard deviation [m]."""

PERIOD, SPEED, BEAMS, RANGE = 0.1, 0.4, 180, 8.0
"""Time between scans [s], speed of the robot [m/s], beams of its laser, and their range [m]."""

NOISE, DRIFT, DRIFT_TURN = 0.015, 0.03, 0.04
"""Noise of ranges [m]; errors of the odometry per metre: length, and heading [rad]."""

PER_BUILDING = 20
"""Number of rides in a building."""

WITHIN, TIME = 0.1, 3.0
"""Error below which a robot is localized [m], and the time in which it must be, after it has left the car [s]."""


@dataclass(frozen=True, slots=True)
class MadeUp:
    """A building that was made up: its layout, what its maps show, and what is really there."""

    layout: BuildingLayout
    layers: dict[str, MapLayers]
    truth: dict[str, NDArray[np.bool_]]


@dataclass(slots=True)
class RideScores:
    """What became of rides.

    Parameters
    ----------
    rides, known, wrong : int
        Number of rides, of those after which the right floor was known, and of those after which a wrong one was.
    seconds, errors : list of float
        Time from leaving the car until the robot was localized [s], and its error then [m], of each ride.
    late : int
        Number of rides after which that took longer than `TIME`.
    """

    rides: int = 0
    known: int = 0
    wrong: int = 0
    late: int = 0
    seconds: list[float] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether all floors were known, and all robots localized in time."""
        return 0 < self.rides == self.known and not self.late

    def rows(self) -> list[dict[str, object]]:
        """Return the figures as a table."""
        within = f"within {WITHIN:g} m, at most {TIME:g} s after leaving"
        rows: list[dict[str, object]] = [
            {"measured": "floor known", "value": f"{self.known} of {self.rides}", "of": "rides"},
            {"measured": "another floor believed", "value": self.wrong, "of": "rides"},
            {"measured": "localized in time", "value": f"{self.rides - self.late} of {self.rides}", "of": within},
        ]
        if self.seconds:
            rows.append({"measured": "time until then", "value": _spread(self.seconds), "of": "s: median, longest"})
            rows.append({"measured": "error then", "value": _spread(self.errors), "of": "m: median, largest"})
        return rows

    def sentences(self) -> list[str]:
        """Return what the rides were."""
        return [
            f"Rides between {FLOORS} floors with an error of the odometry of {DRIFT:.0%}; {WRONG:.0%} end on another "
            f"floor than ordered. {SILENT:.0%} of the lifts say nothing, {LIES:.0%} of the others name any wrong "
            f"floor, and half of the rest the ordered floor whatever happens. {BAROMETER:.0%} of the robots have a "
            f"barometer, which drifts by {AIR:g} m. Floor and pose are found as in the clone of a robot; the "
            "first answer counts."
        ]


def _spread(values: list[float]) -> str:
    return f"{sorted(values)[len(values) // 2]:.3g}, {max(values):.3g}"


# -- buildings that are made up ----------------------------------------------------------------------------------------


def made_up(seed: int) -> MadeUp:
    """Return a building."""
    random = np.random.default_rng(seed)
    names = [f"L{number + 1}" for number in range(FLOORS)]
    frames = {name: Pose2D(*map(float, random.uniform(-20.0, 20.0, 2))) for name in names}
    floors = tuple(
        Floor(name=name, map=f"map-{name}", elevation=STOREY * number, anchor=(frames[name].x, frames[name].y, 0.0))
        for number, name in enumerate(names)
    )
    layers, truth, zones = {}, {}, {}
    for name in names:
        frame = frames[name].inverse()
        info = GridInfo(RESOLUTION, round(WIDTH / RESOLUTION), round(DEPTH / RESOLUTION), Pose2D(frame.x, frame.y))
        data = _floor(random)
        layers[name] = build_layers(GridMap(data, info))
        truth[name] = (_with_furniture(data, random) == OCCUPIED).astype(np.bool_)
        zones[name] = _zones(frame)
    return MadeUp(layout_of(Building(floors=floors), zones), layers, truth)


def _box(data: NDArray[np.int8], corners: tuple[float, float, float, float], value: int = OCCUPIED) -> None:
    x0, y0, x1, y1 = corners
    rows, columns = (slice(round(a / RESOLUTION), round(b / RESOLUTION)) for a, b in ((y0, y1), (x0, x1)))
    data[rows, columns] = value


def _floor(random: np.random.Generator) -> NDArray[np.int8]:
    """Return the cells of a floor: walls, the car with its door, and rooms that differ from floor to floor."""
    data = np.full((round(DEPTH / RESOLUTION), round(WIDTH / RESOLUTION)), FREE, np.int8)
    for wall in (
        (0, 0, WIDTH, 0.15),
        (0, DEPTH - 0.15, WIDTH, DEPTH),
        (0, 0, 0.15, DEPTH),
        (WIDTH - 0.15, 0, WIDTH, DEPTH),
    ):
        _box(data, wall)
    x0, _, x1, y1 = CAR
    _box(data, (x0 - 0.15, 0.0, x1 + 0.15, y1 + 0.15))
    _box(data, CAR, FREE)
    _box(data, (x0 + 0.3, y1, x1 - 0.3, y1 + 0.15), FREE)
    for side in (
        -1.0,
        1.0,
    ):  # what each lobby has in sight, so that somebody who looks around could tell the floors apart
        x, y = 0.5 * (x0 + x1) + side * random.uniform(1.6, 4.0), random.uniform(2.8, 5.0)
        _box(data, (x, y, x + random.uniform(0.2, 0.8), y + random.uniform(0.2, 0.8)))
    for _ in range(int(random.integers(3, 7))):  # rooms and shafts beside the lobby
        x, y = (
            random.uniform(0.3, WIDTH - 2.5),
            random.choice((random.uniform(4.5, DEPTH - 2.0), random.uniform(0.3, 1.5))),
        )
        wide, deep = random.uniform(0.4, 2.2, 2)
        if y + deep < 4.5 and x + wide > x0 - 1.2 and x < x1 + 1.2:
            continue
        _box(data, (x, y, min(x + wide, WIDTH), min(y + deep, DEPTH)))
    return data


def _with_furniture(data: NDArray[np.int8], random: np.random.Generator) -> NDArray[np.int8]:
    """Return a floor with things that its map does not show."""
    real = data.copy()
    for _ in range(3):
        x, y = random.uniform(0.5, WIDTH - 1.0), random.uniform(4.6, DEPTH - 1.0)
        _box(real, (x, y, x + random.uniform(0.2, 0.6), y + random.uniform(0.2, 0.6)))
    return real


def _zones(frame: Pose2D) -> ZoneSet:
    def at(*points: tuple[float, float]) -> list[list[float]]:
        return [list((frame @ Pose2D(x, y))[:2]) for x, y in points]

    x0, y0, x1, y1 = CAR
    return ZoneSet(
        [
            Zone(Polygon([at((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))]), LiftCar(name="lift", lift="lift")),
            Zone(LineString(at((x0 + 0.3, y1 + 0.1), (x1 - 0.3, y1 + 0.1))), Door(name="door", lift="lift")),
        ]
    )


# -- rides -------------------------------------------------------------------------------------------------------------


def _near(random: np.random.Generator, deviation: float, turn: float) -> Pose2D:
    """Return a random pose around the origin, with these standard deviations [m, rad]."""
    x, y = random.normal(0.0, deviation, 2)
    return Pose2D(float(x), float(y), float(random.normal(0.0, turn)))


class LeavingRobot:
    """A robot that leaves a car: where it really is, and what its odometry says."""

    def __init__(self, made: MadeUp, floor: str, pose: Pose2D, random: np.random.Generator) -> None:
        self._info, self._occupied = made.layers[floor].grid.info, made.truth[floor]
        self.pose, self.odom = pose, _near(random, 5.0, 3.0)
        self._random = random
        self._scale, self._turn = 1.0 + random.normal(0.0, DRIFT), random.normal(0.0, DRIFT_TURN)

    def drive(self, metres: float, turn: float) -> None:
        """Drive forward [m], and turn [rad]."""
        self.pose = self.pose @ Pose2D(metres, 0.0, turn)
        self.odom = self.odom @ Pose2D(metres * self._scale, 0.0, turn * self._scale + self._turn * metres)

    def scan(self) -> NDArray[np.float64]:
        """Return the ends of the beams that hit something, in the frame of the robot."""
        angles = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
        ranges = cast_rays(self._occupied, self._info, self.pose, angles, RANGE)
        ranges = ranges + self._random.normal(0.0, NOISE, BEAMS)
        hits = np.isfinite(ranges) & (ranges < RANGE)
        ranges, angles = ranges[hits], angles[hits]
        return np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))


def ride(made: MadeUp, random: np.random.Generator, scores: RideScores) -> None:
    """Let a robot ride once, and add to the scores."""
    landings = {landing.floor: landing for landing in made.layout.landings["lift"]}
    origin, destination = random.permutation(list(landings))[:2].tolist()
    others = [floor for floor in landings if floor not in (origin, destination)]
    floor = str(random.choice(others)) if random.random() < WRONG else destination
    inside = _near(random, 0.15, 0.2)
    robot = LeavingRobot(made, floor, Pose2D(*landings[floor].car) @ inside, random)
    error = _near(random, 0.05, 0.03)
    believed = Pose2D(*landings[origin].car) @ inside @ error
    request, pressure = _request(made, random, (origin, destination, floor))
    search = FloorSearch(request, believed, robot.odom, AmclParameters())
    if pressure:
        search.pressure(pressure, 0.0)
    answered, localized = _leave(robot, search, Pose2D(*landings[floor].car))
    scores.known += answered == floor
    scores.wrong += answered not in ("", floor)
    scores.rides += 1
    if answered != floor or localized is None:
        scores.late += 1
    else:
        scores.seconds.append(localized[0])
        scores.errors.append(localized[1])


def _request(made: MadeUp, random: np.random.Generator, floors: tuple[str, str, str]) -> tuple[FindFloorRequest, float]:
    """Return what the clone of a robot is asked after a ride, and what its barometer says, 0 without one [Pa].

    The ride is from a floor, to a floor, and really ended on the third.
    """
    origin, destination, floor = floors
    building = made.layout.building
    levels = {each.name: each.elevation for each in building.floors}
    landings = {landing.floor: landing for landing in made.layout.landings["lift"]}
    parts = []
    for name, landing in landings.items():
        part = part_around(made.layers[name].grid, Pose2D(*landing.car), name, levels[name])
        change = carried(building, landings[origin], landing, Pose2D(0.0, 0.0))
        parts.append(replace(part, change=Pose.of(change)))
    word = _word(random, list(levels), destination, floor)
    request = FindFloorRequest(origin, destination, word, parts, clear=clear_of(landings[origin]))
    if random.random() >= BAROMETER:
        return request, 0.0
    ground, noise = 101_325.0 + random.normal(0.0, 900.0), random.normal(0.0, 0.3, 2)
    before = ground * math.exp(-(levels[origin] + noise[0]) / GAS)
    drift = random.normal(0.0, AIR)
    request = replace(request, pressure=before, seconds=RIDE)
    return request, ground * math.exp(-(levels[floor] + noise[1] + drift) / GAS)


def _word(random: np.random.Generator, levels: list[str], destination: str, floor: str) -> str:
    """Return the floor that the lift names; empty if it is silent."""
    if random.random() < SILENT:
        return ""
    if random.random() < LIES:
        return str(random.choice([each for each in levels if each != floor]))
    return floor if random.random() < 0.5 else destination


def _leave(robot: LeavingRobot, search: FloorSearch, car: Pose2D) -> tuple[str, tuple[float, float] | None]:
    """Drive out of the car; return the floor that is answered first, and when the robot was localized after leaving.

    That time [s] comes with the error then [m]. As in the clone of a robot, the first answer counts.
    """
    answered = ""
    for seconds in _seconds_outside(robot, car):
        search.scan(robot.scan(), robot.odom)
        if not search.is_known:
            continue
        answer = search.answer()
        answered = answered or answer.floor
        error = answer.pose.planar().distance_to(robot.pose)
        if seconds >= 0.0 and answer.floor == answered and error <= WITHIN:
            return answered, (seconds, error)
    return answered, None


def _seconds_outside(robot: LeavingRobot, car: Pose2D) -> Iterator[float]:
    """Drive the robot, and yield after each period the time since it has left the car [s]; negative before."""
    left: float | None = None
    steps = 0
    while left is None or steps * PERIOD - left <= TIME:
        here = car.inverse() @ robot.pose
        goal = math.atan2(-here.y, 3.2 - here.x)
        turn = min(max(wrap_angle(goal - here.theta), -0.1), 0.1)
        robot.drive(SPEED * PERIOD if here.x < 2.4 else 0.0, turn if here.x < 2.4 else 0.0)
        steps += 1
        if left is None and here.x >= 1.3:
            left = steps * PERIOD
        yield -1.0 if left is None else steps * PERIOD - left


def measure(rides: int, seed: int) -> Iterator[RideScores]:
    """Let robots ride, in another building after each `PER_BUILDING` rides; yield the scores after each ride."""
    random, scores = np.random.default_rng(seed), RideScores()
    made = made_up(seed)
    for number in range(rides):
        if number and number % PER_BUILDING == 0:
            made = made_up(seed + number)
        ride(made, random, scores)
        yield scores
