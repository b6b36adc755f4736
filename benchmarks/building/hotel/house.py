"""Houses of the bench: a hotel that is made up, and buildings of Open-RMF."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.layout import BuildingLayout, layout_of
from ppaas.buildings.planning.planner import BuildingPlanner
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import InvalidInput
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet

RADIUS = 0.2
"""Radius of robots [m]."""

STOREY = 3.5


@dataclass(frozen=True)
class House:
    """Building with the maps of its floors.

    Parameters
    ----------
    building : Building
    grids : mapping of str to GridMap
        Map of each floor, by its name.
    zones : mapping of str to ZoneSet
        Zones of each floor.
    """

    building: Building
    grids: Mapping[str, GridMap]
    zones: Mapping[str, ZoneSet]

    @cached_property
    def layout(self) -> BuildingLayout:
        """Where lifts, doors and ways are."""
        return layout_of(self.building, self.zones)

    @cached_property
    def layers(self) -> dict[str, MapLayers]:
        """Layers of each floor."""
        return {
            name: build_layers(grid, robot_radius=RADIUS, zones=self.zones[name]) for name, grid in self.grids.items()
        }

    @cached_property
    def planner(self) -> BuildingPlanner:
        """Planner over the floors."""
        return BuildingPlanner(self.layout, {name: layers.costmap for name, layers in self.layers.items()})

    def with_devices(self, robots: int, options: Mapping[str, str]) -> "House":
        """Return the house with simulated devices for its lifts and doors.

        Parameters
        ----------
        robots : int
            Number of robots that a car holds.
        options : mapping of str to str
            Options of the devices of some lifts, such as ``?breaks=600``.
        """
        lifts = tuple(
            msgspec.structs.replace(self.building.lift(lift), robots=robots, device=f"sim:{options.get(lift, '')}")
            for lift in self.layout.landings
        )
        doors = tuple(
            msgspec.structs.replace(self.building.door(place.floor, place.door), device="sim:")
            for place in self.layout.doors
            if not place.lift
        )
        return replace(self, building=msgspec.structs.replace(self.building, lifts=lifts, doors=doors))


# -- the hotel that is made up -----------------------------------------------------------------------------------------

WIDTH, HEIGHT, EDGE = 36.0, 20.0, 0.05
"""Size of a floor, and edge of a cell [m]."""

CORRIDOR, LOBBY = (8.0, 12.0), (13.0, 23.0)
"""Where the corridor begins and ends along y, and the lobby before the lifts along x [m]."""

ROOM, DOORWAY, WALL = 6.0, 1.5, 0.2
"""Width of a room and of its doorway, and thickness of walls [m]."""

CAR, SHAFTS, CAR_FLOOR = 2.4, (14.6, 19.0), 1.0
"""Edge of the floor of a car, where the cars begin along x, and along y [m]."""


def hotel(floors: int = 3) -> House:
    """Return a hotel with two lifts side by side, and rooms along a corridor."""
    names = [f"L{number + 1}" for number in range(floors)]
    building = Building(
        floors=tuple(
            Floor(name=name, map=f"hotel-{name}", elevation=STOREY * number) for number, name in enumerate(names)
        ),
        lifts=tuple(LiftSettings(lift=f"lift {number + 1}", wait=10.0) for number in range(len(SHAFTS))),
    )
    return House(building, dict.fromkeys(names, _hotel_floor()), dict.fromkeys(names, _hotel_zones()))


class _Drawing:
    """Grid of walls in which rooms are cut free."""

    def __init__(self) -> None:
        self.info = GridInfo(EDGE, round(WIDTH / EDGE), round(HEIGHT / EDGE))
        self.data: NDArray[np.int8] = np.full((self.info.height, self.info.width), OCCUPIED, np.int8)

    def free(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        rows, columns = (slice(round(low / EDGE), round(high / EDGE)) for low, high in (y, x))
        self.data[rows, columns] = FREE


def _hotel_floor() -> GridMap:
    drawing = _Drawing()
    drawing.free((WALL, WIDTH - WALL), CORRIDOR)
    low, high = CORRIDOR
    for number in range(int(WIDTH / ROOM)):
        begin = ROOM * number
        sides = (begin + WALL, begin + ROOM - WALL)
        door = (begin + 0.5 * (ROOM - DOORWAY), begin + 0.5 * (ROOM + DOORWAY))
        drawing.free(sides, (high + WALL, HEIGHT - WALL))
        drawing.free(door, (high, high + WALL))
        if begin + ROOM <= LOBBY[0] or begin >= LOBBY[1]:
            drawing.free(sides, (WALL, low - WALL))
            drawing.free(door, (low - WALL, low))
    top = CAR_FLOOR + CAR
    drawing.free(LOBBY, (top + WALL, low))
    for begin in SHAFTS:
        middle = begin + 0.5 * CAR
        drawing.free((begin, begin + CAR), (CAR_FLOOR, top))
        drawing.free((middle - 0.5 * DOORWAY, middle + 0.5 * DOORWAY), (top, top + WALL))
    return GridMap(drawing.data, drawing.info)


def _hotel_zones() -> ZoneSet:
    zones, top = [], CAR_FLOOR + CAR
    for number, begin in enumerate(SHAFTS):
        end, lift = begin + CAR, f"lift {number + 1}"
        middle, y = begin + 0.5 * CAR, top + 0.5 * WALL
        ring = [[begin, CAR_FLOOR], [end, CAR_FLOOR], [end, top], [begin, top], [begin, CAR_FLOOR]]
        zones += [
            Zone(Polygon([ring]), LiftCar(name=f"car {number + 1}", lift=lift)),
            Zone(
                LineString([[middle - 0.5 * DOORWAY, y], [middle + 0.5 * DOORWAY, y]]),
                Door(name=f"landing {number + 1}", lift=lift),
            ),
        ]
    return ZoneSet(zones)


# -- buildings of Open-RMF ---------------------------------------------------------------------------------------------


def imported(file: Path) -> House:
    """Return a building of Open-RMF's traffic editor.

    Raises
    ------
    InvalidInput
        It cannot be read, or has no floor.
    """
    # It needs more than the base install.
    from ppaas.imports.buildings.rmf_building import import_building  # noqa: PLC0415

    try:
        content = file.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the building: {error}") from error
    found, _ = import_building(content, file.name, file.name.partition(".")[0])
    return House(
        found.building,
        {name: each.grid for name, each in found.maps.items()},
        {name: each.zones for name, each in found.maps.items()},
    )
