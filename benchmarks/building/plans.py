"""Plans of ``ppaas bench building``: routes over the floors of a tower, beside paths on one of its floors."""

import heapq
import math
from collections.abc import Callable, Sequence
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from ppaas.buildings.building import Building, Floor, LiftSettings
from ppaas.buildings.layout import layout_of
from ppaas.buildings.planning.planner import BuildingPlanner, Spot
from ppaas.buildings.planning.times import BuildingTimes, Traveller
from ppaas.clock import monotonic
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.maps.generate import office
from ppaas.maps.grid import FREE, OCCUPIED, GridMap
from ppaas.planners.batch.cost_matrix import cost_matrix
from ppaas.planners.weights import NEUTRAL
from ppaas.zones.shapes import LineString, Polygon
from ppaas.zones.zone import Door, LiftCar, Zone, ZoneSet

PLAN_US, FLOOR_US, DOOR_MS = 50.0, 15.0, 2.0
"""Bars: mean time of a plan over floors, and of a path on one floor [µs]; longest of a first plan after a door closes
[ms]."""

LIFTS = 4
"""Number of lifts; each stops on all floors."""

RADIUS, SPEED, STOREY = 0.18, 0.5, 4.0
"""Radius [m] and speed [m/s] of the robot, and height of a storey [m]."""

AGREES = 2e-4
"""Largest relative difference of two exact plans: cost fields are rounded."""

RUNS = 5
"""Number of times that all plans are made; the least time of each counts."""


class PlansReport(msgspec.Struct):
    """Plans over floors.

    Parameters
    ----------
    floors, cells : int
        Number of floors, and cells along the edge of each.
    lifts, doors, queries : int
        Number of lifts, of doors of each floor, and of plans.
    built : float
        Time in which the indexes and the lengths between lifts and doors were made [s].
    plan_us, floor_us : float
        Mean time of a plan over floors, and of a path on one floor between two of the same places [µs].
    door_ms : float
        Longest time of a change of a door and the first plan after it [ms].
    checked, wrong : int
        Plans that were compared with Dijkstra's algorithm, and those that took longer, or less, than its.
    """

    floors: int
    cells: int
    lifts: int
    doors: int
    queries: int
    built: float
    plan_us: float
    floor_us: float
    door_ms: float
    checked: int
    wrong: int

    @property
    def passed(self) -> bool:
        """Whether all bars are met, and no plan is wrong."""
        quick = self.plan_us <= PLAN_US and self.floor_us <= FLOOR_US and self.door_ms <= DOOR_MS
        return quick and not self.wrong

    def rows(self) -> list[dict[str, Any]]:
        """Return one row."""
        return [
            {
                "floors": f"{self.floors} of {self.cells}²", "lifts": self.lifts, "doors a floor": self.doors,
                "plans": self.queries, "µs": f"{self.plan_us:.1f}", "µs on a floor": f"{self.floor_us:.1f}",
                "ratio": f"{self.plan_us / self.floor_us:.1f}", "ms after a door": f"{self.door_ms:.2f}",
                "built in s": f"{self.built:.1f}", "checked": self.checked, "wrong": self.wrong,
            }
        ]  # fmt: skip

    def sentences(self) -> list[str]:
        """Return the bars."""
        return [
            f"bars: {PLAN_US:g} µs a plan over floors, {FLOOR_US:g} µs a path on a floor, {DOOR_MS:g} ms for the first "
            "plan after a door closes or opens, and none wrong"
        ]


def measure_plans(
    floors: int, cells: int, queries: int, checked: int, advance: Callable[[], None] = lambda: None
) -> PlansReport:
    """Plan over the floors of a tower of offices.

    Parameters
    ----------
    floors, cells : int
        Number of floors, and cells along the edge of each.
    queries, checked : int
        Number of plans, and of those that are compared with Dijkstra's algorithm.
    advance : callable
        Called after each part.
    """
    grids = [tower_floor(number, cells) for number in range(floors)]
    zones, names = tower_zones(cells * grids[0].info.resolution), [f"L{number}" for number in range(floors)]
    building = Building(
        floors=tuple(Floor(name=each, map=each, elevation=STOREY * number) for number, each in enumerate(names)),
        lifts=tuple(LiftSettings(lift=f"lift {number}") for number in range(LIFTS)),
    )
    costmaps = {name: build_layers(grid, robot_radius=RADIUS).costmap for name, grid in zip(names, grids, strict=True)}
    advance()
    began = monotonic()
    planner = BuildingPlanner(layout_of(building, dict.fromkeys(names, zones)), costmaps)
    built = monotonic() - began
    advance()
    times = planner.times(Traveller(speed=SPEED))
    pairs = _pairs(planner, times, queries)
    plan_us = _mean_us([lambda pair=pair: planner.plan(times, *pair) for pair in pairs])  # type: ignore[misc]
    floor_us = _mean_us([_on_floor(planner, start, goal) for start, goal in _beside(pairs)])
    advance()
    door_ms = 1e3 * _after_doors(planner, times, pairs)
    advance()
    twin = _Twin(planner)
    wrong = sum(not twin.agrees(times, *pair) for pair in pairs[:checked])
    advance()
    doors = len(planner.network.doors) // 2 // floors
    return PlansReport(
        floors, cells, LIFTS, doors, len(pairs), built, plan_us, floor_us, door_ms, min(checked, len(pairs)), wrong
    )


# -- the tower ---------------------------------------------------------------------------------------------------------

_CAR, _WALL = 2.0, 0.2
_OPENING = 1.2


def tower_floor(seed: int, cells: int, resolution: float = 0.05) -> GridMap:
    """Return an office with the shafts of lifts, cut in two by a wall with doors."""
    edge = cells * resolution
    grid = office(seed=seed, width=edge, height=edge, resolution=resolution)
    data, info = grid.data.copy(), grid.info

    def fill(x: float, y: float, width: float, height: float, value: int) -> None:
        low, high = info.to_cells([(x, y), (x + width, y + height)])
        data[max(low[0], 1) : high[0], max(low[1], 1) : high[1]] = value

    fill(0.0, edge / 2.0 - 1.5, edge, 3.0, FREE)
    fill(0.0, edge / 2.0 - _WALL / 2.0, edge, _WALL, OCCUPIED)
    for x in _door_places(edge):
        fill(x, edge / 2.0 - _WALL, _OPENING, 2.0 * _WALL, FREE)
    for x, y in _shafts(edge):
        fill(x - 1.5, y - 1.5, _CAR + 3.0, _CAR + 4.0, FREE)
        fill(x - _WALL, y - _WALL, _CAR + 2.0 * _WALL, _CAR + 2.0 * _WALL, OCCUPIED)
        fill(x, y, _CAR, _CAR, FREE)
        fill(x + 0.4, y + _CAR - 0.05, _OPENING, _WALL + 0.1, FREE)
    return GridMap(data, info)


def tower_zones(edge: float) -> ZoneSet:
    """Return the lifts and doors on each floor, whose edge is ``edge`` [m]."""
    zones = [
        Zone(
            LineString([[x, edge / 2.0], [x + _OPENING, edge / 2.0]]), Door(name=f"door {number}")
        )
        for number, x in enumerate(_door_places(edge))
    ]  # fmt: skip
    for number, (x, y) in enumerate(_shafts(edge)):
        ring = [[x, y], [x + _CAR, y], [x + _CAR, y + _CAR], [x, y + _CAR], [x, y]]
        top = y + _CAR + _WALL / 2.0
        zones += [
            Zone(Polygon([ring]), LiftCar(name=f"car {number}", lift=f"lift {number}")),
            Zone(
                LineString([[x + 0.4, top], [x + 0.4 + _OPENING, top]]),
                Door(name=f"landing {number}", lift=f"lift {number}"),
            ),
        ]
    return ZoneSet(zones)


def _door_places(edge: float) -> list[float]:
    return [edge * (number + 0.5) / LIFTS for number in range(LIFTS)]


def _shafts(edge: float) -> list[tuple[float, float]]:
    near, far = 0.22 * edge, 0.72 * edge
    return [(near, near), (far, near), (near, far), (far, far)]


# -- measuring ---------------------------------------------------------------------------------------------------------


def _pairs(planner: BuildingPlanner, times: BuildingTimes, count: int) -> list[tuple[Spot, Spot]]:
    """Return random places on two floors each, between which a route leads."""
    rng = np.random.default_rng(1)
    pairs = list[tuple[Spot, Spot]]()
    for _ in range(20 * count):
        if len(pairs) == count:
            break
        floors = rng.choice(len(planner.floors), 2, replace=False).tolist()
        start, goal = (_place(planner, number, rng) for number in floors)
        if planner.plan(times, start, goal) is not None:
            pairs.append((start, goal))
    return pairs


def _place(planner: BuildingPlanner, floor: int, rng: np.random.Generator) -> Spot:
    costmap = planner.floors[floor].paths.costmap
    while True:
        cell = rng.integers(0, costmap.info.shape)
        if costmap.data[tuple(cell)] < 253:
            x, y = costmap.info.to_world(cell).tolist()
            return planner.network.floors[floor], x, y


def _beside(pairs: Sequence[tuple[Spot, Spot]]) -> list[tuple[Spot, Spot]]:
    """Return pairs of the same places that are on one floor each."""
    on_floor: dict[str, list[Spot]] = {}
    for place in (each for pair in pairs for each in pair):
        on_floor.setdefault(place[0], []).append(place)
    return [(one, other) for places in on_floor.values() for one, other in zip(places[::2], places[1::2], strict=False)]


def _on_floor(planner: BuildingPlanner, start: Spot, goal: Spot) -> Callable[[], NDArray[np.int32]]:
    paths = planner.floors[planner.network.number_of[start[0]]].paths

    def plan() -> NDArray[np.int32]:
        one, other = paths.cell(*start[1:]), paths.cell(*goal[1:])
        assert one is not None
        assert other is not None
        return paths.path(one, other)

    return plan


def _mean_us(calls: Sequence[Callable[[], object]]) -> float:
    """Return the mean of the least time of each call [µs]; other calls are between its runs."""
    best = np.full(len(calls), math.inf)
    for _ in range(RUNS):
        for number, call in enumerate(calls):
            began = monotonic()
            call()
            best[number] = min(best[number], monotonic() - began)
    return 1e6 * float(best.mean())


def _after_doors(planner: BuildingPlanner, times: BuildingTimes, pairs: Sequence[tuple[Spot, Spot]]) -> float:
    """Return the longest time of a first plan after a door of one of its floors closed or opened [s]."""
    longest = 0.0
    for number, (start, goal) in enumerate(pairs[:100]):
        door = start[0], f"door {number % LIFTS}"
        for closed in ([door], []):
            least = math.inf
            for _ in range(RUNS):
                planner.state.close([] if closed else [door])
                planner.plan(times, start, goal)
                began = monotonic()
                planner.state.close(closed)
                planner.plan(times, start, goal)
                least = min(least, monotonic() - began)
            longest = max(longest, least)
    return longest


class _Twin:
    """Dijkstra's algorithm over the places of lifts and doors, with lengths from cost fields over all cells."""

    def __init__(self, planner: BuildingPlanner) -> None:
        self._planner = planner
        self._lengths = [
            self._fields(number, self._places(number), self._places(number)) for number in range(len(planner.floors))
        ]

    def agrees(self, times: BuildingTimes, start: Spot, goal: Spot) -> bool:
        """Return whether a plan takes as long as the one of Dijkstra's algorithm."""
        found = self._planner.plan(times, start, goal)
        expected = self._seconds(times, start, goal)
        return found is not None and abs(found.seconds - expected) <= AGREES * expected

    def _seconds(self, times: BuildingTimes, start: Spot, goal: Spot) -> float:
        network, speed = self._planner.network, times.traveller.speed
        here, there = network.number_of[start[0]], network.number_of[goal[0]]
        first = self._fields(here, [start[1:]], self._places(here))[0] / speed
        last = self._fields(there, self._places(there), [goal[1:]])[:, 0] / speed
        queue = list(zip(first.tolist(), network.parts[here], strict=True))
        heapq.heapify(queue)
        done, best = set[int](), math.inf
        while queue:
            seconds, at = heapq.heappop(queue)
            if at in done or seconds >= best:
                continue
            done.add(at)
            floor = network.junctions[at].floor
            part = network.parts[floor]
            if floor == there:
                best = min(best, seconds + last[at - part.start])
            for other in part:
                metres = self._lengths[floor][at - part.start, other - part.start]
                heapq.heappush(queue, (seconds + metres / speed, other))
            for link in (*network.links, *network.doors):
                if link.start == at:
                    heapq.heappush(queue, (seconds + link.seconds + link.metres / speed, link.goal))
        return best

    def _places(self, floor: int) -> list[tuple[float, ...]]:
        """Return the places of the junctions of a floor, at the middles of their cells."""
        own = self._planner.floors[floor]
        return [tuple(own.paths.costmap.info.to_world(np.array(cell)).tolist()) for cell in own.cells]

    def _fields(
        self, floor: int, starts: Sequence[Sequence[float]], goals: Sequence[Sequence[float]]
    ) -> NDArray[np.float64]:
        costmap = self._planner.floors[floor].paths.costmap
        data = np.where(costmap.data < 253, 0, 254).astype(np.uint8)
        data[costmap.data == 255] = 0  # the planner allows unknown cells
        data.flags.writeable = False
        plain = Costmap(data, costmap.info)
        return cost_matrix(plain, np.array(starts), np.array(goals)) / NEUTRAL * costmap.info.resolution
