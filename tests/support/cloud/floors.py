"""Building of two or three floors: its maps, its simulation, and its record in a cloud."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

from ppaas.buildings.building import Building, Floor, LiftSettings, json_of
from ppaas.buildings.layout import layout_of
from ppaas.geometry import Pose2D
from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet
from robots.client.rest import RestClient
from robots.sim.floors.building import SimulatedBuilding
from robots.sim.floors.device_server import DeviceServer
from robots.sim.simulator import Simulator
from tests.support.cloud.cloud import publish_map
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
    lifts=(LiftSettings(lift="north", speed=2.0, doors=1.0),),
)


HIGHER = Building(floors=(*BUILDING.floors, Floor(name="L3", map="floor-3", elevation=6.0)), lifts=BUILDING.lifts)
"""The building with a third floor."""

FLOORS = {"floor-1": GROUND, "floor-2": LOFT, "floor-3": ATTIC}
"""Floors by their maps."""


def simulated_building(seed: int = 0, building: Building = BUILDING) -> SimulatedBuilding:
    """Return the building with its lift; robots begin on the first floor."""
    layout = layout_of(building, {floor.name: ZONES for floor in building.floors})
    return SimulatedBuilding(layout, {floor.name: FLOORS[floor.map] for floor in building.floors}, seed)


@asynccontextmanager
async def simulating(building: SimulatedBuilding) -> AsyncIterator[Building]:
    """Step a building, and serve its devices; yield its record with their URLs."""
    async with DeviceServer(building) as devices:
        stepping = asyncio.create_task(Simulator(building).run())
        try:
            yield devices.served(building.layout.building)
        finally:
            stepping.cancel()
            await asyncio.gather(stepping, return_exceptions=True)


async def put_building(rest: RestClient, record: Building) -> None:
    """Publish the maps of all floors with their zones, and the record of the building."""
    for floor in record.floors:
        await publish_map(rest, floor.map, FLOORS[floor.map])
        await rest.put_zones(floor.map, geojson_of(ZONES))
    warnings = (await rest.put_building("hotel", json_of(record)))["warnings"]
    assert warnings == []


async def ended(rest: RestClient, robot: str, goal_id: str) -> dict[str, Any]:
    """Wait for the end of a goal, and return it."""
    async with asyncio.timeout(120.0):
        while (last := await rest.get(f"/v1/robots/{robot}/goals/{goal_id}"))["state"] in ("pending", "active"):
            await asyncio.sleep(0.2)
    return last


async def ended_task(rest: RestClient, path: str) -> dict[str, Any]:
    """Wait for the end of a task, and return it."""
    async with asyncio.timeout(120.0):
        while (last := await rest.get(path))["ended"] is None:
            await asyncio.sleep(0.2)
    return last
