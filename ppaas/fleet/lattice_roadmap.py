"""Lattice roadmap: square cells of a map, which are free of obstacles for robots of a radius."""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import GoalOutsideMap, InvalidInput
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import BLOCKED, Roadmap
from ppaas.fleet.robot_sizes import RobotSizes
from ppaas.maps.grid import GridInfo
from ppaas.planners.watch import proceed

# -- lattices of places, and the one whose largest connected part has the most -----------------------------------------

PHASES = 4
"""Number of offsets along x, and along y, of which all pairs are tried."""

FINE_PHASES = 16
"""Largest number of offsets along an axis that are tried around the best pair."""

TURNED_SAMPLES = 2
"""Number of samples for each edge of a map cell, along moves that do not run along the rows of the map."""


class PlaceLattice(NamedTuple):
    """Places at equal distances along x and y in the map frame, (columns,) and (rows,) float64 arrays [m]."""

    xs: NDArray[np.float64]
    ys: NDArray[np.float64]


class Moves(NamedTuple):
    """Free places of a lattice and moves between them, as ``Roadmap.of_moves`` takes them."""

    free: NDArray[np.bool_]
    in_rows: NDArray[np.bool_]
    in_columns: NDArray[np.bool_]


class Clear:
    """The part of a map where the centre of a robot may be.

    Parameters
    ----------
    mask : (h, w) bool array
        True in map cells where it may be; nowhere outside.
    info : GridInfo
        Geometry of the map.
    """

    def __init__(self, mask: NDArray[np.bool_], info: GridInfo) -> None:
        self._padded = np.pad(mask, 1)
        self._info = info

    @property
    def is_turned(self) -> bool:
        """Whether rows of the map do not run along the x axis of the map frame."""
        return self._info.origin.theta != 0.0

    def at(self, lattice: PlaceLattice) -> NDArray[np.bool_]:
        """Return True for each place of a lattice where a robot may be, (rows, columns) bool."""
        info, (xs, ys) = self._info, lattice
        if self.is_turned:
            cells = info.to_cells(np.stack(np.meshgrid(xs, ys), axis=-1))
            rows, columns = cells[..., 0], cells[..., 1]
        else:
            rows = info.to_cells(np.stack([np.full_like(ys, info.origin.x), ys], axis=-1))[:, :1]
            columns = info.to_cells(np.stack([xs, np.full_like(xs, info.origin.y)], axis=-1))[:, 1]
        found: NDArray[np.bool_] = self._padded[_inside(rows, info.height), _inside(columns, info.width)]
        return found

    def moves(self, lattice: PlaceLattice, spacing: float) -> Moves:
        """Return the free places of a lattice, and the moves on whose whole line a robot may be."""
        free, samples = self.at(lattice), self._samples(spacing)
        in_rows, in_columns = free[:, :-1] & free[:, 1:], free[:-1] & free[1:]
        for part in np.arange(1, samples) / samples * spacing:
            if not (in_rows.any() or in_columns.any()):
                break
            in_rows &= self.at(PlaceLattice(lattice.xs[:-1] + part, lattice.ys))
            in_columns &= self.at(PlaceLattice(lattice.xs, lattice.ys[:-1] + part))
        return Moves(free, in_rows, in_columns)

    def _samples(self, spacing: float) -> int:
        each = TURNED_SAMPLES if self.is_turned else 1
        return int(each * spacing / self._info.resolution) + 1


def _inside(index: NDArray[np.int64], size: int) -> NDArray[np.int64]:
    """Return indices into a padded axis; all outside of the axis become one of its borders."""
    return np.clip(index, -1, size) + 1


class Bounds(NamedTuple):
    """Smallest and largest x and y of a map in the map frame [m]."""

    least_x: float
    least_y: float
    most_x: float
    most_y: float

    @classmethod
    def of(cls, info: GridInfo) -> "Bounds":
        """Return the bounds of a map."""
        rows, columns = (-0.5, info.height - 0.5), (-0.5, info.width - 0.5)
        corners = info.to_world([(row, column) for row in rows for column in columns])
        return cls(*corners.min(axis=0).tolist(), *corners.max(axis=0).tolist())

    def lattice(self, spacing: float, x: float, y: float) -> PlaceLattice:
        """Return the lattice whose squares cover the map, with offsets from 0 to 1 spacings along x and y."""
        xs = _places(self.least_x, self.most_x, spacing, x)
        return PlaceLattice(xs, _places(self.least_y, self.most_y, spacing, y))

    def places(self, spacing: float) -> int:
        """Return the largest number of places of a lattice."""
        sides = (self.most_x - self.least_x, self.most_y - self.least_y)
        return math.prod(math.ceil(min(side / spacing, 1e9)) + 1 for side in sides)


def _places(least: float, most: float, spacing: float, offset: float) -> NDArray[np.float64]:
    first = least + (offset - 0.5) * spacing
    return first + spacing * np.arange(math.floor((most - first) / spacing + 0.5) + 1, dtype=np.float64)


def best_lattice(
    clear: Clear, bounds: Bounds, spacing: float, resolution: float, check: Callable[[], None]
) -> tuple[PlaceLattice, Moves]:
    """Return the lattice whose largest connected part has the most places, and its moves.

    All pairs of some offsets along x and y are tried, then many offsets along y beside the best one along x, then the
    other way round. Of lattices that are as good, the first is returned.
    """
    fine = min(FINE_PHASES, max(1, math.ceil(spacing / resolution)))
    coarse, every = _offsets(PHASES), _offsets(fine)
    best, most = (0.5, 0.5), -1

    def look_at(offsets: Iterable[tuple[float, float]]) -> None:
        nonlocal best, most
        for offset in offsets:
            check()
            size = largest_part(clear.moves(bounds.lattice(spacing, *offset), spacing))
            if size > most:
                best, most = offset, size

    look_at((x, y) for y in coarse for x in coarse)
    look_at([(best[0], y) for y in every])
    look_at([(x, best[1]) for x in every])
    lattice = bounds.lattice(spacing, *best)
    return lattice, clear.moves(lattice, spacing)


def _offsets(count: int) -> list[float]:
    return [(k + 0.5) / count for k in range(count)]


def largest_part(moves: Moves) -> int:
    """Return the number of places of the largest part of a lattice that moves connect."""
    if not moves.free.any():
        return 0
    numbers = np.arange(moves.free.size).reshape(moves.free.shape)
    one = np.concatenate([numbers[:, :-1][moves.in_rows], numbers[:-1][moves.in_columns]])
    other = np.concatenate([numbers[:, 1:][moves.in_rows], numbers[1:][moves.in_columns]])
    root = numbers.ravel().copy()
    while len(one):
        np.minimum.at(root, np.maximum(one, other), np.minimum(one, other))
        while not np.array_equal(up := root[root], root):
            root = up
        one, other = root[one], root[other]
        apart = one != other
        one, other = one[apart], other[apart]
    return int(np.bincount(root).max())


# -- the roadmap -------------------------------------------------------------------------------------------------------

MOST_PLACES = 1 << 20
"""Largest number of cells, free or not, of a lattice."""


@dataclass(frozen=True, slots=True)
class LatticeRoadmap(MetricRoadmap):
    """Square cells in the map frame, whose rows run along its x axis.

    Parameters
    ----------
    x0, y0 : float
        Centre of row 0, column 0 [m]; row r has y = y0 + r · spacing, column c has x = x0 + c · spacing.
    """

    x0: float
    y0: float

    def centres_of(self, cells: NDArray[np.int32] | slice) -> NDArray[np.float64]:
        """Return the centres of some cells, (k, 2) float64 array of x, y [m] in the map frame."""
        places = self.roadmap.cells[cells]
        return np.array([self.x0, self.y0]) + self.spacing * places[:, ::-1].astype(np.float64)

    def centre(self, cell: int) -> tuple[float, float]:
        """Return the centre of a cell: x, y [m] in the map frame."""
        row, column = self.roadmap.cells[cell].tolist()
        return self.x0 + self.spacing * column, self.y0 + self.spacing * row

    def _around(self, x: float, y: float, reach: float) -> NDArray[np.int32]:
        height, width = self.roadmap.numbers.shape
        reach += self.spacing
        rows = _range((y - self.y0) / self.spacing, reach / self.spacing, height)
        columns = _range((x - self.x0) / self.spacing, reach / self.spacing, width)
        numbers = self.roadmap.numbers[rows, columns]
        near: NDArray[np.int32] = numbers[numbers != BLOCKED]
        return near

    def _beside(self, cells: NDArray[np.int32], x: float, y: float) -> NDArray[np.float64]:
        aside = np.maximum(np.abs(self.centres_of(cells) - (x, y)) - self.spacing / 2, 0.0)
        return np.asarray(np.hypot(*aside.T))

    def _apart(self, cells: NDArray[np.int32], x: float, y: float) -> NDArray[np.float64]:
        row, column = round((y - self.y0) / self.spacing), round((x - self.x0) / self.spacing)
        height, width = self.roadmap.numbers.shape
        if not (0 <= row < height and 0 <= column < width):
            raise GoalOutsideMap(f"{x:g}, {y:g} is outside the map")
        return np.asarray(np.hypot(*(self.centres_of(cells) - (x, y)).T))


def _range(middle: float, reach: float, size: int) -> slice:
    first, last = max(middle - reach, 0.0), min(middle + reach, size - 1.0)
    return slice(math.floor(first), math.ceil(last) + 1) if first <= last else slice(0)


def lattice_roadmap(
    to_lethal: NDArray[np.float32], info: GridInfo, sizes: RobotSizes, check: Callable[[], None] = proceed
) -> LatticeRoadmap:
    """Return the roadmap of a map for robots of a radius.

    A cell is free where the distance of the map at its centre is at least the radius and the margin, and a robot may
    move between two cells where all of the straight line between their centres keeps that distance. Distances come from
    `MapLayers`, from the centre of a map cell to the centre of a lethal one.

    The places of all cells follow from two offsets along x and y, which are chosen such that the largest connected part
    has the most cells. So an aisle that is narrower than a cell, but wide enough for a robot, gets a row of cells. One
    choice serves the whole map: of several such aisles whose distances are no multiples of the spacing, some may get no
    cells. Give a smaller margin, or draw the map such that they are, if that matters.

    Parameters
    ----------
    to_lethal : (h, w) float32 array
        Distance from each map cell to the nearest lethal cell [m], 0 in unknown cells (`clearance_of`).
    info : GridInfo
        Geometry of the map.
    sizes : RobotSizes
        Smaller robots also enter cells where only they have room; larger ones do not. A move on which a robot has no
        room although it has in both cells is left out for all.
    check : callable
        Called between two lattices that are tried; ends the work by raising.

    Raises
    ------
    InvalidInput
        There would be too many cells, or no robot of that size fits on the map.
    """
    bounds = Bounds.of(info)
    if (places := bounds.places(sizes.spacing)) > MOST_PLACES:
        raise InvalidInput(
            f"the map is too large for robots so small: it has {places} places at {sizes.spacing:g} m, and at most "
            f"{MOST_PLACES} are allowed; plan on a part of the map"
        )
    *others, clear = [Clear(mask, info) for mask in sizes.room(to_lethal)]
    lattice, moves = best_lattice(clear, bounds, sizes.spacing, info.resolution, check)
    if not moves.free.any():
        raise InvalidInput(
            f"a robot of radius {sizes.radius:g} m with a margin of {sizes.margin:g} m fits nowhere on the map"
        )
    every = [*(each.moves(lattice, sizes.spacing) for each in others), moves]
    roadmap = _of_sizes(every) if others else Roadmap.of_moves(*moves)
    return LatticeRoadmap(roadmap, sizes.spacing, float(lattice.xs[0]), float(lattice.ys[0]), radii=sizes.radii)


def _of_sizes(moves: Sequence[Moves]) -> Roadmap:
    """Return the roadmap of robots of several sizes from the moves that each of them has room for, smallest first."""
    free, in_rows, in_columns = moves[0]
    for each in moves[1:]:
        in_rows = in_rows & ~(each.free[:, :-1] & each.free[:, 1:] & ~each.in_rows)
        in_columns = in_columns & ~(each.free[:-1] & each.free[1:] & ~each.in_columns)
    roadmap = Roadmap.of_moves(free, in_rows, in_columns)
    rows, columns = roadmap.cells.T
    return replace(roadmap, barred=np.stack([~each.free[rows, columns] for each in moves]))
