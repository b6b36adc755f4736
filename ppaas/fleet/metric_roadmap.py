"""Metric roadmap: the cells of a fleet on a map in metres."""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import GoalOccupied, InvalidInput
from ppaas.fleet.roadmap import Roadmap
from ppaas.fleet.robot_sizes import TINY

Cells = NDArray[np.int32]
"""Numbers of cells, (k,) int32."""


@dataclass(frozen=True, slots=True)
class MetricRoadmap(ABC):
    """A roadmap and its geometry. Moves are straight lines between the centres of cells, and each cell has an area.

    Parameters
    ----------
    roadmap : Roadmap
    spacing : float
        Width of a cell, and least distance of the centres of two cells [m].
    radii : tuple of float
        Radius of robots of each size, in ascending order [m]; empty if all may enter all cells.
    """

    PLACES: ClassVar[str] = "room for a robot"
    """Name of the places near which goals may be, for errors."""

    IS_GRID: ClassVar[bool] = True
    """True if moves lead along the rows and columns of the roadmap."""

    roadmap: Roadmap
    spacing: float
    radii: tuple[float, ...] = field(default=(), kw_only=True)

    @abstractmethod
    def centres_of(self, cells: Cells | slice) -> NDArray[np.float64]:
        """Return the centres of some cells, (k, 2) float64 array of x, y [m] in the map frame."""

    @abstractmethod
    def centre(self, cell: int) -> tuple[float, float]:
        """Return the centre of a cell: x, y [m] in the map frame."""

    @abstractmethod
    def _around(self, x: float, y: float, reach: float) -> Cells:
        """Return the numbers of cells in ascending order, among them all with a part within a distance of a place."""

    @abstractmethod
    def _beside(self, cells: Cells, x: float, y: float) -> NDArray[np.float64]:
        """Return the distances of a place from the areas of cells [m], 0 within them."""

    @abstractmethod
    def _apart(self, cells: Cells, x: float, y: float) -> NDArray[np.float64]:
        """Return the distances of a goal from cells [m]; raise ``GoalOutsideMap`` if it is outside the map."""

    @property
    def centres(self) -> NDArray[np.float64]:
        """Centres of all cells, (v, 2) float64 array of x, y [m] in the map frame."""
        return self.centres_of(slice(None))

    @property
    def longest_move(self) -> float:
        """Length of the longest move [m]."""
        return self.spacing

    def size_of(self, radius: float) -> int:
        """Return the size of robots of a radius [m]: the smallest one that is as large, or the largest of all."""
        return min(int(np.searchsorted(self.radii, radius - TINY)), max(len(self.radii) - 1, 0))

    def nearest(self, x: float, y: float, within: float, size: int = 0) -> int:
        """Return the number of the cell that is nearest to a goal; the lowest number if several are.

        Parameters
        ----------
        x, y : float
            The goal [m] in the map frame.
        within : float
            Largest distance of the cell [m].
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
        cells = self._entered(self._around(x, y, within), size)
        apart = self._apart(cells, x, y)
        if not (apart <= within).any():
            raise GoalOccupied(f"there is no {self.PLACES} within {within:g} m of {x:g}, {y:g}")
        return int(cells[np.argmin(apart)])

    def nearby(self, x: float, y: float, within: float, size: int = 0) -> list[int]:
        """Return the numbers of the cells whose centres are within a distance of a place [m], the nearest one first.

        Cells that robots of a size do not enter are left out.
        """
        self._check_finite(x, y, within)
        cells = self._entered(self._around(x, y, within), size)
        apart = np.hypot(*(self.centres_of(cells) - (x, y)).T)
        order = np.argsort(apart, kind="stable")
        return [int(cell) for cell in cells[order[: int((apart <= within).sum())]]]

    def closest(self, x: float, y: float) -> int:
        """Return the number of the cell whose centre is closest to a place, however far it is [m]."""
        self._check_finite(x, y)
        return int(np.argmin(np.hypot(*(self.centres - (x, y)).T)))

    def touched(self, x: float, y: float, radius: float) -> Cells:
        """Return the numbers of all cells whose area a disc touches, (k,) int32, in ascending order.

        A disc that only reaches the border of an area, as the largest one in the cell beside it does, does not touch
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
        cells = self._around(x, y, radius)
        near: Cells = cells[self._beside(cells, x, y) < max(radius - TINY, TINY)]
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

    def _entered(self, cells: Cells, size: int) -> Cells:
        return cells[~self.roadmap.barred[size, cells]] if len(self.roadmap.barred) else cells

    def _check_finite(self, *values: float) -> None:
        if not all(map(math.isfinite, values)):
            raise InvalidInput(f"places and distances must be finite numbers of metres, not {values}")
