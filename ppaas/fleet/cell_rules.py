"""Rules of zones on the cells of a fleet: closed moves, cells without stops, areas with little room, cars of lifts."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import BLOCKED, Roadmap
from ppaas.polygons import Points
from ppaas.zones.shapes import Area
from ppaas.zones.zone import Capacity, Door, KeepOut, LiftCar, NoStop, OneWay, Zone

AGAINST, ALONG = -0.5, 0.5
"""Cosine of the angle between a move and the direction of a zone below which it leads against it; and, where a zone is
strict, below which it does not lead along it."""

SAMPLES = 4
"""Number of parts of a move whose ends are checked."""


@dataclass(frozen=True, slots=True)
class CellRules:
    """Rules of the zones that are in force, on the cells of a map.

    Parameters
    ----------
    roadmap : Roadmap
        Cells with the moves that are left, and with areas that have room for few robots. Where there are cars of lifts,
        it has a row of barred cells for each `kind` of robot.
    no_stop : frozenset of int
        Cells in which robots do not stop.
    areas : tuple of str
        Name of the zone of each area.
    cars : tuple of frozenset of int
        Cells in which a part of a robot is in the car of a lift, or in its door, for each lift.
    """

    roadmap: Roadmap
    no_stop: frozenset[int] = frozenset()
    areas: tuple[str, ...] = ()
    cars: tuple[frozenset[int], ...] = ()

    def areas_of(self, cell: int) -> set[int]:
        """Return the areas that a cell is in."""
        if not self.areas:
            return set()
        bits = int(self.roadmap.areas[cell])
        return {area for area in range(len(self.areas)) if bits >> area & 1}

    def car_of(self, cell: int | None) -> int | None:
        """Return the number of the car that a cell is in; None if it is in none."""
        return next((car for car, cells in enumerate(self.cars) if cell in cells), None)

    def kind(self, size: int, at: int, goal: int | None) -> int:
        """Return the row of barred cells of a robot of a size: nobody gives way into a car, whose doors may be shut.

        A robot enters the car of its goal, and leaves the one in which it is for a goal outside. Without a goal it
        stays in the car.
        """
        here = self.car_of(at)
        car = here if goal is None or (there := self.car_of(goal)) is None else there
        if car is None:
            return size * (2 * len(self.cars) + 1)
        return size * (2 * len(self.cars) + 1) + 1 + car + (len(self.cars) if goal is None else 0)


def rules_on(cells: MetricRoadmap, zones: Sequence[Zone], radius: float) -> CellRules:
    """Return the rules of zones for robots of a radius.

    A robot is in a zone of the kind ``no_stop`` or ``capacity`` if a part of it is. It does not enter ``keep_out``
    zones with any part, and leaves those in which it is. A move is in a ``one_way`` zone if its middle is.

    Parameters
    ----------
    cells : MetricRoadmap
        Cells without the rules.
    zones : sequence of Zone
        Zones in force; of other kinds too.
    radius : float
        Radius of the robots [m].
    """
    closed = np.zeros(cells.roadmap.neighbours.shape, np.bool_)
    moves = _Moves(cells)
    for zone in zones:
        if isinstance(zone.rule, KeepOut):
            closed |= moves.into(zone.area, radius)
        elif isinstance(zone.rule, OneWay):
            closed |= moves.against(zone)
    no_stop = np.zeros(len(cells.roadmap), np.bool_)
    for zone in zones:
        if isinstance(zone.rule, NoStop):
            no_stop |= zone.area.distances(cells.centres) < radius
    few = [(zone.name, zone.rule.robots, zone.area) for zone in zones if isinstance(zone.rule, Capacity)]
    areas = np.zeros(len(cells.roadmap) if few else 0, np.uint64)
    for number, (_, _, area) in enumerate(few):
        areas |= (area.distances(cells.centres) < radius).astype(np.uint64) << np.uint64(number)
    roadmap = cells.roadmap.without_moves(closed) if closed.any() else cells.roadmap
    roadmap = replace(roadmap, areas=areas, room=np.array([robots for _, robots, _ in few], np.int32))
    cars = _cars(cells, zones, radius)
    if cars:
        roadmap = replace(roadmap, barred=_barred(roadmap, np.stack(cars)))
    return CellRules(
        roadmap,
        frozenset(np.nonzero(no_stop)[0].tolist()),
        tuple(name for name, _, _ in few),
        tuple(frozenset(np.nonzero(car)[0].tolist()) for car in cars),
    )


def _cars(cells: MetricRoadmap, zones: Sequence[Zone], radius: float) -> list[NDArray[np.bool_]]:
    """Return in which cells a part of a robot is in the car of each lift, or in its door, (v,) bool each."""
    found: defaultdict[str, NDArray[np.bool_]] = defaultdict(lambda: np.zeros(len(cells.roadmap), np.bool_))
    for zone in zones:
        if isinstance(zone.rule, LiftCar):
            found[zone.rule.lift_id] |= zone.area.distances(cells.centres) < radius
        elif isinstance(zone.rule, Door) and zone.rule.lift:
            found[zone.rule.lift] |= zone.area.distances(cells.centres) < radius
    return [car for _, car in sorted(found.items()) if car.any()]


def _barred(roadmap: Roadmap, cars: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the cells that robots of each size and kind do not enter: see `CellRules.kind`."""
    anywhere: NDArray[np.bool_] = np.logical_or.reduce(cars)
    kinds = np.concatenate([anywhere[np.newaxis], anywhere & ~cars, ~cars])
    sizes = roadmap.barred if len(roadmap.barred) else np.zeros((1, len(roadmap)), np.bool_)
    barred: NDArray[np.bool_] = (sizes[:, np.newaxis] | kinds).reshape(-1, len(roadmap))
    return barred


class _Moves:
    """Moves of a roadmap, as lines."""

    def __init__(self, cells: MetricRoadmap) -> None:
        centres, neighbours = cells.centres, cells.roadmap.neighbours
        self._shape = neighbours.shape
        self._exists = neighbours != BLOCKED
        starts, ends = cells.roadmap.moves.T
        self._starts, self._ends = centres[starts], centres[ends]

    def into(self, area: Area, radius: float) -> NDArray[np.bool_]:
        """Return the moves by which robots of a radius [m] that are outside of an area touch it, (v, 4) bool."""
        near = np.zeros(len(self._starts), np.bool_)
        for part in range(1, SAMPLES + 1):
            near |= area.distances(self._at(part / SAMPLES)) < radius
        return self._spread(near & (area.distances(self._starts) >= radius))

    def against(self, zone: Zone) -> NDArray[np.bool_]:
        """Return the moves that a one-way zone closes, (v, 4) bool."""
        rule, area, middles = zone.rule, zone.area, self._at(0.5)
        assert isinstance(rule, OneWay)
        if area.lines:
            directions = area.directions(middles)
        else:
            assert rule.direction is not None, "a polygon has a direction"
            directions = np.array([[np.cos(rule.direction), np.sin(rule.direction)]])
        along = self._ends - self._starts
        cosines = (along * directions).sum(axis=1) / np.hypot(*along.T)
        return self._spread((cosines < (ALONG if rule.strict else AGAINST)) & (area.distances(middles) == 0.0))

    def _at(self, part: float) -> Points:
        return np.asarray(self._starts + part * (self._ends - self._starts))

    def _spread(self, moves: NDArray[np.bool_]) -> NDArray[np.bool_]:
        spread = np.zeros(self._shape, np.bool_)
        spread[self._exists] = moves
        return spread
