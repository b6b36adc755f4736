"""Building of two or three floors: its maps, a world with all, and what carries a robot in the car."""

import asyncio
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager, suppress
from typing import Any

import numpy as np

from ppaas.buildings.building import Building, Floor, LiftSettings, json_of
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet
from robots.client.rest import RestClient
from tests.support.cloud.cloud import publish_map
from tests.support.cloud.drive import Drive
from tests.support.world.planar_world import walled_map

WIDTH, HEIGHT = 6.6, 4.5
SHAFT = [
    (0.0, 2.2, 0.3, 4.5),
    (1.9, 2.2, 2.2, 4.5),
    (0.0, 2.2, 0.55, 2.45),
    (1.65, 2.2, 2.2, 2.45),
    (0.0, 4.2, 2.2, 4.5),
]
"""Walls of the car, which is open towards the lobby below."""

GROUND = walled_map(WIDTH, HEIGHT, [*SHAFT, (4.3, 1.5, 4.5, 4.5)])
LOFT = walled_map(WIDTH, HEIGHT, [*SHAFT, (3.2, 2.6, 3.8, 3.2), (5.0, 0.8, 5.6, 1.2)])
ATTIC = walled_map(WIDTH, HEIGHT, [*SHAFT, (2.9, 0.3, 3.2, 1.6), (4.0, 3.2, 5.2, 3.5)])
BETWEEN = WIDTH + 2.0
"""Distance between the floors, which are beside each other in the world [m]."""

START, GOAL = Pose2D(1.8, 1.0, 1.57), Pose2D(2.6, 1.4, 0.0)
CAR = [[0.3, 2.45], [1.9, 2.45], [1.9, 4.2], [0.3, 4.2], [0.3, 2.45]]
ZONES = ZoneSet(
    [
        Zone(Polygon([CAR]), LiftCar(name="car", lift="north")),
        Zone(LineString([[0.55, 2.3], [1.65, 2.3]]), Door(name="landing", lift="north")),
    ]
)
BUILDING = Building(
    floors=(Floor(name="L1", map="floor-1"), Floor(name="L2", map="floor-2", elevation=3.0)),
    lifts=(LiftSettings(lift="north", device="sim:", speed=2.0, doors=1.0),),
)


HIGHER = Building(floors=(*BUILDING.floors, Floor(name="L3", map="floor-3", elevation=6.0)), lifts=BUILDING.lifts)
"""The building with a third floor."""

FLOORS = {"floor-1": GROUND, "floor-2": LOFT, "floor-3": ATTIC}
"""Floors by their maps, in the order in which they are beside each other in the world."""


def world_of(*floors: GridMap) -> GridMap:
    """Return floors beside each other."""
    resolution = floors[0].info.resolution
    gap = np.zeros((floors[0].info.height, round((BETWEEN - WIDTH) / resolution)), np.int8)
    data = np.hstack([part for floor in floors for part in (floor.data, gap)][:-1])
    return GridMap(data, GridInfo(resolution, data.shape[1], data.shape[0]))


async def put_building(rest: RestClient, building: Building = BUILDING) -> None:
    """Publish the maps of all floors with their zones, and the building."""
    for floor in building.floors:
        await publish_map(rest, floor.map, FLOORS[floor.map])
        await rest.put_zones(floor.map, geojson_of(ZONES))
    warnings = (await rest.put_building("hotel", json_of(building)))["warnings"]
    assert warnings == []


@asynccontextmanager
async def carried(
    clients: list[RestClient], drive: Drive, robot: str, *, lies: Sequence[str] = ()
) -> AsyncIterator[list[str]]:
    """Carry a robot in the car to another floor, once its clone is on that; yield the maps that it was on.

    The cloud is asked by the last of the clients; it may be away for a while. The first rides end on the maps in
    ``lies`` instead. A robot is not carried to the floor that it is on already.
    """
    maps: list[str] = ["floor-1"]
    really, wrong = "floor-1", list(lies)

    async def carry() -> None:
        nonlocal really
        while True:
            name = maps[-1]
            with suppress(PPaaSError):
                name = (await clients[-1].get(f"/v1/robots/{robot}"))["map"]
            if name != maps[-1]:
                maps.append(name)
                if name == really:
                    continue
                floor = wrong.pop(0) if wrong else name
                base, names = drive.world.robots[0].base, list(FLOORS)
                x = base.pose.x - BETWEEN * names.index(really)
                assert 0.3 < x < 1.9 and base.pose.y > 2.45, "it is in the car"
                base.carry_to(Pose2D(x + BETWEEN * names.index(floor), base.pose.y, base.pose.theta))
                really = floor
            await asyncio.sleep(0.05)

    carrying = asyncio.create_task(carry())
    try:
        yield maps
    finally:
        carrying.cancel()
        await asyncio.gather(carrying, return_exceptions=True)


async def ended(rest: RestClient, robot: str, goal: dict[str, Any]) -> dict[str, Any]:
    """Wait for the end of a goal, and return it."""
    async with asyncio.timeout(120.0):
        while (last := await rest.get(f"/v1/robots/{robot}/goals/{goal['id']}"))["state"] in ("pending", "active"):
            await asyncio.sleep(0.2)
    return last
