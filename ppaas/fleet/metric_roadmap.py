"""Metric roadmap: the cells of a fleet on a map in metres, which are free of obstacles for robots of a radius."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.map_layers import MapLayers
from ppaas.errors import GoalOccupied, GoalOutsideMap, InvalidInput
from ppaas.fleet.lattice import Bounds, Clear, Moves, best_lattice
from ppaas.fleet.roadmap import BLOCKED, Roadmap
from ppaas.maps.grid import UNKNOWN, GridInfo
from ppaas.planners.watch import proceed

MOST_PLACES = 1 << 20
"""Largest number of cells, free or not, of a metric roadmap."""

TINY = 1e-9
"""Length that rounding of numbers may make up [m]: a disc that is less deep in a square only reaches its border."""


@dataclass(frozen=True, slots=True)
class MetricRoadmap:
    """A roadmap and its geometry: square cells in the map frame, whose rows run along its x axis.

    Parameters
    ----------
    roadmap : Roadmap
    spacing : float
        Distance of the centres of neighbouring cells, and side of a cell [m].
    x0, y0 : float
        Centre of row 0, column 0 [m]; row r has y = y0 + r · spacing, column c has x = x0 + c · spacing.
    radii : tuple of float
        Radius of robots of each size, in ascending order [m]; empty if all may enter all cells.
    """

    roadmap: Roadmap
    spacing: float
    x0: float
    y0: float
    radii: tuple[float, ...] = ()

    def size_of(self, radius: float) -> int:
        """Return the size of robots of a radius [m]: the smallest one that is as large, or the largest of all."""
        return min(int(np.searchsorted(self.radii, radius - TINY)), max(len(self.radii) - 1, 0))

    @property
    def centres(self) -> NDArray[np.float64]:
        """Centres of all cells, (v, 2) float64 array of x, y [m] in the map frame."""
        return self._centres_of(self.roadmap.cells)

    def nearest(self, x: float, y: float, within: float, size: int = 0) -> int:
        """Return the number of the cell whose centre is nearest to a place; the lowest number if several are.

        Parameters
        ----------
        x, y : float
            The place [m] in the map frame.
        within : float
            Largest distance of the centre [m].
        size : int
            Size of the robot, which enters the cell.

        Raises
        ------
        InvalidInput
            The place or the distance is not finite.
        GoalOutsideMap
            The place is outside the map.
        GoalOccupied
            No robot may stand so near to the place.
        """
        self._check_finite(x, y, within)
        row, column = round((y - self.y0) / self.spacing), round((x - self.x0) / self.spacing)
        height, width = self.roadmap.numbers.shape
        if not (0 <= row < height and 0 <= column < width):
            raise GoalOutsideMap(f"{x:g}, {y:g} is outside the map")
        cells = self._entered(self._around(x, y, within), size)
        apart = np.hypot(*(self._centres_of(self.roadmap.cells[cells]) - (x, y)).T)
        if not (apart <= within).any():
            raise GoalOccupied(f"there is no room for a robot within {within:g} m of {x:g}, {y:g}")
        return int(cells[np.argmin(apart)])

    def centre(self, cell: int) -> tuple[float, float]:
        """Return the centre of a cell: x, y [m] in the map frame."""
        row, column = self.roadmap.cells[cell].tolist()
        return self.x0 + self.spacing * column, self.y0 + self.spacing * row

    def nearby(self, x: float, y: float, within: float, size: int = 0) -> list[int]:
        """Return the numbers of the cells whose centres are within a distance of a place [m], the nearest one first.

        Cells that robots of a size do not enter are left out.
        """
        self._check_finite(x, y, within)
        cells = self._entered(self._around(x, y, within), size)
        apart = np.hypot(*(self._centres_of(self.roadmap.cells[cells]) - (x, y)).T)
        order = np.argsort(apart, kind="stable")
        return [int(cell) for cell in cells[order[: int((apart <= within).sum())]]]

    def closest(self, x: float, y: float) -> int:
        """Return the number of the cell whose centre is closest to a place, however far it is [m]."""
        self._check_finite(x, y)
        return int(np.argmin(np.hypot(*(self.centres - (x, y)).T)))

    def touched(self, x: float, y: float, radius: float) -> NDArray[np.int32]:
        """Return the numbers of all cells whose square a disc touches, (k,) int32, in ascending order.

        A disc that only reaches the border of a square, as the largest one in the square beside it does, does not touch
        it.

        Parameters
        ----------
        x, y, radius : float
            Centre in the map frame, and radius [m]; the centre may be outside the map.

        Raises
        ------
        InvalidInput
            A number is not finite.
        """
        self._check_finite(x, y, radius)
        cells = self._around(x, y, radius + self.spacing)
        aside = np.maximum(np.abs(self._centres_of(self.roadmap.cells[cells]) - (x, y)) - self.spacing / 2, 0.0)
        near: NDArray[np.int32] = cells[np.hypot(*aside.T) < max(radius - TINY, TINY)]
        return near

    def touched_along(self, begin: tuple[float, float], end: tuple[float, float], radius: float) -> set[int]:
        """Return the numbers of all cells that a disc touches on the straight way between two places.

        The disc is tried at places of which two are at most a sixteenth of its radius apart.

        Raises
        ------
        InvalidInput
            A number is not finite, or the radius is not positive.
        """
        self._check_finite(*begin, *end, radius)
        if radius <= 0.0:
            raise InvalidInput(f"the radius must be positive, not {radius:g}")
        steps = max(math.ceil(math.dist(begin, end) / (radius / 16.0)), 1)
        places = np.linspace(begin, end, steps + 1).tolist()
        return {cell for x, y in places for cell in self.touched(x, y, radius).tolist()}

    def _entered(self, cells: NDArray[np.int32], size: int) -> NDArray[np.int32]:
        return cells[~self.roadmap.barred[size, cells]] if len(self.roadmap.barred) else cells

    def _around(self, x: float, y: float, reach: float) -> NDArray[np.int32]:
        """Return the numbers of cells with centres in a square, in ascending order."""
        height, width = self.roadmap.numbers.shape
        rows = _range((y - self.y0) / self.spacing, reach / self.spacing, height)
        columns = _range((x - self.x0) / self.spacing, reach / self.spacing, width)
        numbers = self.roadmap.numbers[rows, columns]
        near: NDArray[np.int32] = numbers[numbers != BLOCKED]
        return near

    def _centres_of(self, places: NDArray[np.int32]) -> NDArray[np.float64]:
        return np.array([self.x0, self.y0]) + self.spacing * places[:, ::-1].astype(np.float64)

    def _check_finite(self, *values: float) -> None:
        if not all(map(math.isfinite, values)):
            raise InvalidInput(f"places and distances must be finite numbers of metres, not {values}")


def _range(middle: float, reach: float, size: int) -> slice:
    first, last = max(middle - reach, 0.0), min(middle + reach, size - 1.0)
    return slice(math.floor(first), math.ceil(last) + 1) if first <= last else slice(0)


def clearance_of(layers: MapLayers) -> NDArray[np.float32]:
    """Return the distances of a map's cells to the nearest lethal cell [m], and 0 in unknown cells."""
    return np.where(layers.grid.data == UNKNOWN, np.float32(0.0), layers.to_lethal)


def metric_roadmap(
    to_lethal: NDArray[np.float32],
    info: GridInfo,
    radius: float,
    margin: float,
    spacing: float | None = None,
    *,
    clearance: float | None = None,
    smaller: Sequence[float] = (),
    check: Callable[[], None] = proceed,
) -> MetricRoadmap:
    """Return the roadmap of a map for robots of a radius.

    A cell is free where the distance of the map at its centre is at least the radius and the margin, and a robot may
    move between two cells where all of the straight line between their centres keeps that distance. Distances are those
    of `MapLayers`, from the centre of a map cell to the centre of a lethal one.

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
    radius, margin : float
        Radius of the robots, and the distance by which they may stray from their paths [m].
    spacing : float, optional
        Distance of the centres of neighbouring cells [m]; by default a robot's diameter and twice the margin. Two
        robots in neighbouring cells must fit.
    clearance : float, optional
        Least distance of robots' ways from lethal cells [m], by default the radius and the margin; more where sensors
        see walls nearer than the map has them.
    smaller : sequence of float
        Radii of smaller robots [m], which also enter cells where only they have room; larger ones do not. A move on
        which a robot has no room although it has in both cells is left out for all.
    check : callable
        Called between two lattices that are tried; ends the work by raising.

    Raises
    ------
    InvalidInput
        A size is not positive or not finite, the spacing is too small, there would be too many cells, or no robot of
        that size fits on the map.
    """
    reach = radius + margin
    spacing = 2.0 * reach if spacing is None else spacing
    _check_sizes(radius, margin, spacing)
    bounds = Bounds.of(info)
    if (places := bounds.places(spacing)) > MOST_PLACES:
        raise InvalidInput(
            f"the map is too large for robots so small: it has {places} places at {spacing:g} m, and at most "
            f"{MOST_PLACES} are allowed; plan on a part of the map"
        )
    more = max(reach, clearance or 0.0) - radius
    clear = Clear(to_lethal >= np.float32(radius + more), info)
    lattice, moves = best_lattice(clear, bounds, spacing, info.resolution, check)
    if not moves.free.any():
        raise InvalidInput(f"a robot of radius {radius:g} m with a margin of {margin:g} m fits nowhere on the map")
    radii = sorted({each for each in smaller if each < radius - TINY})
    others = [Clear(to_lethal >= np.float32(each + more), info).moves(lattice, spacing) for each in radii]
    roadmap = _of_sizes([*others, moves]) if radii else Roadmap.of_moves(*moves)
    sizes = (*radii, radius) if radii else ()
    return MetricRoadmap(roadmap, spacing, float(lattice.xs[0]), float(lattice.ys[0]), sizes)


def _of_sizes(moves: Sequence[Moves]) -> Roadmap:
    """Return the roadmap of robots of several sizes from the moves that each of them has room for, smallest first."""
    free, in_rows, in_columns = moves[0]
    for each in moves[1:]:
        in_rows = in_rows & ~(each.free[:, :-1] & each.free[:, 1:] & ~each.in_rows)
        in_columns = in_columns & ~(each.free[:-1] & each.free[1:] & ~each.in_columns)
    roadmap = Roadmap.of_moves(free, in_rows, in_columns)
    rows, columns = roadmap.cells.T
    return replace(roadmap, barred=np.stack([~each.free[rows, columns] for each in moves]))


def _check_sizes(radius: float, margin: float, spacing: float) -> None:
    if not (math.isfinite(radius) and radius > 0.0):
        raise InvalidInput(f"the radius must be a positive number of metres, not {radius}")
    if not (math.isfinite(margin) and margin >= 0.0):
        raise InvalidInput(f"the margin must be at least 0 m and finite, not {margin}")
    least = 2.0 * (radius + margin)
    if not (math.isfinite(spacing) and spacing >= least - TINY):
        raise InvalidInput(
            f"the spacing must be at least {least:g} m, where robots in neighbouring cells fit: {spacing}"
        )
