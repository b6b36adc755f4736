"""Lattice roadmap: square cells of a map, which are free of obstacles for robots of a radius."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import GoalOutsideMap, InvalidInput
from ppaas.fleet.lattice import Bounds, Clear, Moves, best_lattice
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.roadmap import BLOCKED, Roadmap
from ppaas.fleet.robot_sizes import RobotSizes
from ppaas.maps.grid import GridInfo
from ppaas.planners.watch import proceed

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
