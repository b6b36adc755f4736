"""Small random buildings, and the jumps of the twin on them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.building import Building, DoorSettings, Floor, LiftSettings, WaySettings
from ppaas.buildings.layout import BEFORE_DOOR, BuildingLayout, layout_of
from ppaas.buildings.planning.planner import BuildingPlanner
from ppaas.buildings.planning.times import Traveller
from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridInfo
from ppaas.zones.shapes import LineString, Point, Polygon
from ppaas.zones.zone import Door, LiftCar, OneWay, Passage, Zone, ZoneSet
from tests.reference.buildings import Jump, Spot

SIZE, RESOLUTION = 24, 0.25


def lift(name: str, x: float, y: float) -> list[Zone]:
    """Return the car of a lift with its lower left corner at a place [m], and its door above it."""
    ring = [[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0], [x, y]]
    line = LineString([[x, y + 1.1], [x + 1.0, y + 1.1]])
    return [Zone(Polygon([ring]), LiftCar(name=name)), Zone(line, Door(name=f"door of {name}", lift=name))]


def door(name: str, x: float, y: float) -> Zone:
    """Return a door 1 m wide along x."""
    return Zone(LineString([[x, y], [x + 1.0, y]]), Door(name=name))


def gate(door_name: str, x: float, y: float, direction: float) -> Zone:
    """Return a one-way zone over a door at the same place."""
    ring = [[x, y - 0.1], [x + 1.0, y - 0.1], [x + 1.0, y + 0.1], [x, y + 0.1], [x, y - 0.1]]
    return Zone(Polygon([ring]), OneWay(name=f"gate of {door_name}", direction=direction))


def passage(way: str, x: float, y: float) -> Zone:
    """Return an end of a way."""
    return Zone(Point([x, y]), Passage(name=way, way=way, yaw=0.0))


def costmap(free: NDArray[np.bool_], resolution: float = RESOLUTION) -> Costmap:
    """Return the costmap of free and blocked cells."""
    data = np.where(free, 0, 254).astype(np.uint8)
    data.flags.writeable = False
    return Costmap(data, GridInfo(resolution, free.shape[1], free.shape[0]))


@dataclass(frozen=True)
class RandomBuilding:
    """Building with 2 to 4 floors, up to 3 lifts, 2 ways and 2 doors a floor, equal for equal seeds."""

    layout: BuildingLayout
    free: list[NDArray[np.bool_]]

    @classmethod
    def of(cls, seed: int) -> "RandomBuilding":
        """Return a building."""
        rng = np.random.default_rng(seed)
        floors = int(rng.integers(2, 5))
        free = [rng.random((SIZE, SIZE)) > 0.2 for _ in range(floors)]
        zones: list[list[Zone]] = [[] for _ in range(floors)]
        lifts, ways = [f"lift {n}" for n in range(rng.integers(0, 4))], [f"way {n}" for n in range(rng.integers(0, 3))]
        for name in lifts:
            for number in rng.choice(floors, int(rng.integers(2, floors + 1)), replace=False).tolist():
                zones[number] += lift(name, *rng.uniform(0.0, 4.0, 2).tolist())
        for name in ways:
            for number in rng.choice(floors, 2, replace=False).tolist():
                zones[number].append(passage(name, *rng.uniform(0.3, 5.7, 2).tolist()))
        for number, found in enumerate(zones):
            for name in [f"{number}/{n}" for n in range(rng.integers(0, 3))]:
                x, y = rng.uniform(0.5, 5.0, 2).tolist()
                found.append(door(name, x, y))
                if rng.random() < 0.4:
                    found.append(gate(name, x, y, float(rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.6))))
        building = Building(
            floors=tuple(Floor(name=f"L{n}", map=f"m{n}", elevation=float(3 * n)) for n in range(floors)),
            lifts=tuple(
                LiftSettings(lift=name, wait=float(rng.uniform(0, 9)), speed=float(rng.uniform(0.5, 2)))
                for name in lifts
            ),
            ways=tuple(_way(name, rng) for name in ways),
            doors=tuple(
                DoorSettings(floor=f"L{number}", door=each.name, opens=float(rng.uniform(0, 4)), device="sim:")
                for number, found in enumerate(zones) for each in found
                if isinstance(each.rule, Door) and not each.rule.lift
            ),
        )  # fmt: skip
        layout = layout_of(building, {f"L{n}": ZoneSet(found) for n, found in enumerate(zones)})
        return cls(layout, free)

    def planner(self) -> BuildingPlanner:
        """Return a planner on it."""
        return BuildingPlanner(self.layout, {f"L{n}": costmap(free) for n, free in enumerate(self.free)})

    def spot(self, rng: np.random.Generator, floor: int | None = None) -> tuple[Spot, tuple[str, float, float]]:
        """Return a free place, as the twin and as the planner have it."""
        number = int(rng.integers(len(self.free))) if floor is None else floor
        row, column = rng.permutation(np.argwhere(self.free[number]))[0].tolist()
        return (number, row, column), (f"L{number}", (column + 0.5) * RESOLUTION, (row + 0.5) * RESOLUTION)


def two_floors(more: Sequence[Zone] = (), **changes: Any) -> RandomBuilding:
    """Return a building of two floors without walls, with the lift ``north`` and what else is given for both."""
    zones = ZoneSet([*lift("north", 1.0, 1.0), *more])
    building = Building(floors=tuple(Floor(name=f"L{n}", map=f"m{n}", elevation=4.0 * n) for n in range(2)), **changes)
    free = [np.ones((SIZE, SIZE), np.bool_) for _ in range(2)]
    return RandomBuilding(layout_of(building, {"L0": zones, "L1": zones}), free)


def _way(name: str, rng: np.random.Generator) -> WaySettings:
    changes: dict[str, Any] = {"kind": str(rng.choice(["stairs", "ramp"]))}
    if rng.random() < 0.5:
        changes["labels"] = {"legs": "4"}
    if rng.random() < 0.5:
        changes["length"] = float(rng.uniform(1, 20))
    return WaySettings(way=name, **changes)


def shut(planner: BuildingPlanner) -> list[NDArray[np.bool_]]:
    """Return the free cells of each floor with its doors shut."""
    return [floor.paths.costmap.data == 0 for floor in planner.floors]


def jumps_of(planner: BuildingPlanner, traveller: Traveller, closed: frozenset[tuple[str, str]]) -> list[Jump]:
    """Return all jumps that a robot may make, from the settings of the building."""
    layout, speed, jumps = planner.network.layout, traveller.speed, list[Jump]()
    cells = {
        number: (junction.floor, *cell)
        for floor, part in zip(planner.floors, planner.network.parts, strict=True)
        for number, cell in zip(part, floor.cells, strict=True)
        if cell is not None
        for junction in [planner.network.junctions[number]]
    }
    for one, here in cells.items():
        for other, there in cells.items():
            a, b = planner.network.junctions[one].of, planner.network.junctions[other].of
            if one == other or type(a) is not type(b):
                continue
            rise = abs(layout.building.floors[here[0]].elevation - layout.building.floors[there[0]].elevation)
            if hasattr(a, "lift") and hasattr(a, "car") and a.lift == b.lift and here[0] != there[0]:  # type: ignore[union-attr]
                settings = layout.building.lift(a.lift)
                seconds = settings.wait + 2 * settings.doors + rise / settings.speed
                walked = math.dist(a.wait[:2], a.car[:2]) + math.dist(b.wait[:2], b.car[:2])  # type: ignore[union-attr]
                jumps.append((here, there, seconds + walked / speed, a.lift))
            elif hasattr(a, "way") and a.way == b.way:  # type: ignore[union-attr]
                way = layout.building.way(a.way)
                if way.kind == "stairs" and not traveller.stairs:
                    continue
                if any(traveller.labels.get(name) != value for name, value in way.labels.items()):
                    continue
                length = way.length or math.hypot(math.dist(a.place[:2], b.place[:2]), rise)  # type: ignore[union-attr]
                jumps.append((here, there, length / speed, a.way))
            elif hasattr(a, "ends") and a == b and (a.floor, a.door) not in closed:
                (x0, y0, _), (x1, y1, _) = planner.network.junctions[one].place, planner.network.junctions[other].place
                if a.one_way is not None and (x1 - x0) * math.cos(a.one_way) + (y1 - y0) * math.sin(a.one_way) < 0.0:
                    continue
                opens = layout.building.door(a.floor, a.door).opens
                jumps.append((here, there, opens + 2 * BEFORE_DOOR / speed, ""))
    return [jump for jump in jumps if jump[3] not in traveller.avoid]
