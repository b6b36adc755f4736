"""Simulated building of two floors, with a lift and a door."""

import numpy as np

from ppaas.buildings.building import Building, DoorSettings, Floor, LiftSettings
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.laser import LaserModel
from robots.sim.odometry import OdometryNoise
from robots.sim.robot import SimulatedRobotModel, TurtlebotModel
from tests.support.world.planar_world import walled_map

SHAFT = [(2.0, 2.0, 2.2, 4.0), (3.8, 2.0, 4.0, 4.0), (2.2, 2.0, 2.4, 2.2), (3.6, 2.0, 3.8, 2.2)]
"""Walls of the car, whose doors are to the south."""


MODEL = SimulatedRobotModel(
    base=TurtlebotModel(slip=0.0), laser=LaserModel(sigma=0.0), odometry=OdometryNoise(drift=0.0)
)
IN_CAR, BEFORE = Pose2D(3.0, 3.0, -np.pi / 2), Pose2D(3.0, 1.0, np.pi / 2)


def turned(places: list[list[float]]) -> list[list[float]]:
    """Return places on the map of the ground floor on that of the upper one, which is turned by a quarter."""
    return [[6.0 - y, x] for x, y in places]


def zones(floor: str) -> ZoneSet:
    """Return the zones of a floor."""
    car = [[2.2, 2.2], [3.8, 2.2], [3.8, 3.9], [2.2, 3.9], [2.2, 2.2]]
    door = [[2.4, 2.1], [3.6, 2.1]]
    if floor == "up":
        car, door = turned(car), turned(door)
    found = [
        Zone(Polygon([car]), LiftCar(name="car", lift="A")),
        Zone(LineString(door), Door(name="landing", lift="A")),
    ]
    return ZoneSet(
        [*found, Zone(LineString([[1.0, 0.1], [1.0, 1.9]]), Door(name="glass"))] if floor == "low" else found
    )


def building(door: str = "sim:", doors: float = 1.0, *, seed: int = 0) -> SimulatedBuilding:
    """Return two floors, of which the upper map is turned by a quarter, with a lift at y = 2.1 and a door at x = 1."""
    low = walled_map(6.0, 4.2, [*SHAFT, (0.0, 1.9, 2.0, 2.0)])
    data = np.rot90(low.data, -1).copy()  # rows are from below, so this turns by a quarter to the left
    up = GridMap(data, GridInfo(0.05, data.shape[1], data.shape[0], Pose2D(6.0 - 4.2, 0.0)))
    return SimulatedBuilding(layout(door, doors), {"low": low, "up": up}, seed)


def layout(door: str, doors: float = 1.0) -> BuildingLayout:
    """Return the layout of the building."""
    record = Building(
        floors=(Floor(name="low", map="1"), Floor(name="up", map="2", elevation=3.0, anchor=(0.0, 6.0, -np.pi / 2))),
        lifts=(LiftSettings(lift="A", device="sim:", speed=2.0, doors=doors),),
        doors=(DoorSettings(floor="low", door="glass", opens=doors, device=door),),
    )
    found = layout_of(record, {"low": zones("low"), "up": zones("up")})
    assert found.warnings == ()
    return found
