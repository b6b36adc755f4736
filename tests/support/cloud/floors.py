"""Building of two floors: its maps, a world with both, and what carries a robot in the car."""

import asyncio
from collections.abc import AsyncIterator
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


def world_of(*floors: GridMap) -> GridMap:
    """Return floors beside each other."""
    gap = np.zeros((floors[0].info.height, round((BETWEEN - WIDTH) / floors[0].info.resolution)), np.int8)
    data = np.hstack([floors[0].data, gap, floors[1].data])
    return GridMap(data, GridInfo(floors[0].info.resolution, data.shape[1], data.shape[0]))


async def put_building(rest: RestClient) -> None:
    """Publish both maps with their zones, and the building."""
    for name, grid in (("floor-1", GROUND), ("floor-2", LOFT)):
        await publish_map(rest, name, grid)
        await rest.put_zones(name, geojson_of(ZONES))
    warnings = (await rest.put_building("hotel", json_of(BUILDING)))["warnings"]
    assert warnings == []


@asynccontextmanager
async def carried(clients: list[RestClient], drive: Drive, robot: str) -> AsyncIterator[list[str]]:
    """Carry a robot in the car to the other floor, once its clone is on that; yield the maps that it was on.

    The cloud is asked by the last of the clients; it may be away for a while.
    """
    maps: list[str] = ["floor-1"]

    async def carry() -> None:
        while True:
            name = maps[-1]
            with suppress(PPaaSError):
                name = (await clients[-1].get(f"/v1/robots/{robot}"))["map"]
            if name != maps[-1]:
                maps.append(name)
                base = drive.world.robots[0].base
                assert 0.3 < base.pose.x < 1.9 and base.pose.y > 2.45, "it is in the car"
                base.carry_to(Pose2D(base.pose.x + BETWEEN, base.pose.y, base.pose.theta))
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


async def ended_task(rest: RestClient, path: str) -> dict[str, Any]:
    """Wait for the end of a task, and return it."""
    async with asyncio.timeout(120.0):
        while (last := await rest.get(path))["ended"] is None:
            await asyncio.sleep(0.2)
    return last
