"""Building of the demo: maps of its floors, its record, and the places where robots are sent to."""

import math
from dataclasses import dataclass

import numpy as np

from ppaas.buildings.building import Building, DoorSettings, Floor, LiftSettings
from ppaas.buildings.layout import layout_of
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.zones.shapes import LineString, Point, Polygon
from ppaas.zones.zone import Dock, Door, LiftCar, Zone, ZoneSet
from robots.demo.options import DemoOptions
from robots.sim.courses import Course
from robots.sim.docks.fitting import fit_chargers
from robots.sim.floors.building import SimulatedBuilding

Box = tuple[float, float, float, float]
"""Least x and y, greatest x and y [m]."""

BUILDING = "house"
"""Id of the building, with which the ids of its maps begin."""

FLOORS, HEIGHT = ("L1", "L2", "L3"), 3.2
"""Floors, and the height of each [m]."""

WIDTH, DEPTH, RESOLUTION = 14.0, 10.0, 0.05
"""Size of a floor, and edge of a cell [m]."""

LIFTS = {"west": 4.0, "east": 8.4}
"""Lifts, and the western wall of the car of each, which is 1.6 m wide [m]."""

ROOMS = (2.3, 7.0, 11.7)
"""Middle of each room in the south, and of its doorway [m]."""

PLACES = (*((x, 1.9, 0.0) for x in ROOMS), (1.8, 8.8, 0.0), (12.2, 8.8, math.pi))
"""Places where robots are sent to, on each floor: x, y [m], yaw [rad]."""

LONGEST = 60.0
"""Bound of the length of a way between two places, with its waits as metres [m]."""

_WALLS: tuple[Box, ...] = (
    (0.0, 4.4, 1.7, 4.6), (2.9, 4.4, 6.4, 4.6), (7.6, 4.4, 11.1, 4.6), (12.3, 4.4, WIDTH, 4.6),
    (4.6, 0.0, 4.7, 4.4), (9.3, 0.0, 9.4, 4.4), (5.9, 7.8, 8.1, DEPTH),
)  # fmt: skip
"""Walls of rooms, and the block between the lifts."""


def _shaft(west: float) -> tuple[Box, ...]:
    """Return the walls of a car, with its opening to the south."""
    east = west + 1.6
    return (
        (west - 0.3, 7.8, west, DEPTH), (east, 7.8, east + 0.3, DEPTH),
        (west, 7.8, west + 0.25, 8.05), (east - 0.25, 7.8, east, 8.05), (west, 9.8, east, DEPTH),
    )  # fmt: skip


def floor_map(rng: np.random.Generator) -> GridMap:
    """Return the map of a floor, with furniture at random in its rooms."""
    info = GridInfo(RESOLUTION, round(WIDTH / RESOLUTION), round(DEPTH / RESOLUTION))
    data = np.full(info.shape, FREE, np.int8)
    data[:2] = data[-2:] = OCCUPIED
    data[:, :2] = data[:, -2:] = OCCUPIED
    boxes = [*_WALLS, *(box for west in LIFTS.values() for box in _shaft(west))]
    for middle in ROOMS:
        boxes += _furniture(middle, rng)
    for box in boxes:
        (first_row, first_column), (row, column) = info.to_cells([box[:2], box[2:]])
        data[first_row:row, first_column:column] = OCCUPIED
    return GridMap(data, info)


def _furniture(middle: float, rng: np.random.Generator) -> list[Box]:
    """Return a cupboard in each corner of a room that is far from the door."""
    found = []
    for side in (-1.0, 1.0):
        width, depth = rng.uniform(0.3, 0.6), rng.uniform(0.3, 1.4)
        wall = middle + side * 2.2
        found.append((min(wall, wall - side * width), 0.1, max(wall, wall - side * width), 0.1 + float(depth)))
    return found


def zones_of_floor(floor: str) -> ZoneSet:
    """Return the cars and landings of a floor; on the lowest one, also a door of a room and a dock."""
    zones = []
    for lift, west in LIFTS.items():
        east = west + 1.6
        car = [[west, 8.05], [east, 8.05], [east, 9.8], [west, 9.8], [west, 8.05]]
        zones.append(Zone(Polygon([car]), LiftCar(name=lift, lift=lift)))
        landing = [[west + 0.25, 7.9], [east - 0.25, 7.9]]
        zones.append(Zone(LineString(landing), Door(name=f"landing {lift}", lift=lift)))
    if floor == FLOORS[0]:
        zones.append(Zone(LineString([[1.7, 4.5], [2.9, 4.5]]), Door(name="store")))
        zones.append(Zone(Point([0.5, 6.2]), Dock(name="charger", yaw=math.pi)))
    return ZoneSet(zones)


def record() -> Building:
    """Return the record of the building; its devices have no addresses yet."""
    floors = tuple(
        Floor(name=name, map=f"{BUILDING}-{name}", elevation=HEIGHT * number) for number, name in enumerate(FLOORS)
    )
    lifts = tuple(LiftSettings(lift=lift, speed=1.5, wait=15.0, doors=2.0) for lift in LIFTS)
    return Building(floors=floors, lifts=lifts, doors=(DoorSettings(floor=FLOORS[0], door="store", device="sim:"),))


@dataclass(frozen=True, slots=True)
class FloorCourse:
    """Course of a robot: its goals, and the floor of each; the last floor is where it starts."""

    course: Course
    floors: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BuildingStage:
    """Maps and zones of the floors, the simulated building, and courses of the robots, which are in it already."""

    grids: dict[str, GridMap]
    zones: dict[str, ZoneSet]
    simulated: SimulatedBuilding
    courses: list[FloorCourse]


def set_stage(options: DemoOptions) -> BuildingStage:
    """Make the building, choose the courses, and place the robots at their starts.

    Raises
    ------
    InvalidParameter
        There are more robots than places on a floor.
    """
    if options.robots > len(PLACES):
        raise InvalidParameter(f"the building of the demo has room for {len(PLACES)} robots, not {options.robots}")
    rng = np.random.default_rng(options.seed)
    grids = {name: floor_map(rng) for name in FLOORS}
    zones = {name: zones_of_floor(name) for name in FLOORS}
    simulated = SimulatedBuilding(layout_of(record(), zones), grids, options.seed)
    fit_chargers(simulated.floors[FLOORS[0]], zones[FLOORS[0]])
    courses = _courses(options.robots, options.goals, rng)
    for each in courses:
        simulated.add_robot(each.course.start, floor=each.floors[-1])
    return BuildingStage(grids, zones, simulated, courses)


def _courses(robots: int, goals: int, rng: np.random.Generator) -> list[FloorCourse]:
    """Choose courses whose goals are each on another floor than the one before; no two robots have a common place."""
    owned = {floor: rng.permutation(len(PLACES)) for floor in FLOORS}
    courses = []
    for robot in range(robots):
        floors = [FLOORS[robot % len(FLOORS)]]
        for _ in range(goals):
            floors.append(str(rng.choice([name for name in FLOORS if name != floors[-1]])))
        start, *poses = (Pose2D(*PLACES[owned[floor][robot]]) for floor in floors)
        courses.append(FloorCourse(Course(start, tuple(poses), (LONGEST,) * goals), (*floors[1:], floors[0])))
    return courses
