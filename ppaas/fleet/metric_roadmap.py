"""Metric roadmap: the cells of a fleet on a map in metres, and problems whose starts and goals are in metres."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import CausesAt
from ppaas.errors import (
    GoalOccupied,
    GoalOutsideMap,
    InvalidInput,
    NoValidPath,
    PlanningError,
    StartOccupied,
    StartOutsideMap,
)
from ppaas.fleet.problem import FleetProblem
from ppaas.fleet.roadmap import Roadmap
from ppaas.fleet.robot_sizes import TINY
from ppaas.maps.grid import GridInfo
from ppaas.planners.watch import proceed

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


# -- problems whose starts and goals are in metres ---------------------------------------------------------------------

WITHIN = 0.75
"""Largest distance of a start or a goal from the centre of its cell [spacings]: a half of a diagonal, and a little."""

MOST_DISTANCES = 100_000_000
"""Largest number of robots times cells: distances and guides take 3 bytes each."""


@dataclass(frozen=True, slots=True)
class MetricFloor:
    """A map for robots of a radius.

    Parameters
    ----------
    to_lethal : (h, w) float32 array
        Distance from each map cell to the nearest lethal cell [m], 0 in unknown cells.
    info : GridInfo
        Geometry of the map.
    metric : MetricRoadmap
        Its roadmap for robots of this radius and some margin.
    radius : float
        Radius of the robots [m].
    causes : callable, optional
        Returns what makes a place lethal, for texts.
    """

    to_lethal: NDArray[np.float32]
    info: GridInfo
    metric: MetricRoadmap
    radius: float
    causes: CausesAt | None = None

    def problem(
        self, starts: NDArray[np.float64], goals: NDArray[np.float64], check: Callable[[], None] = proceed
    ) -> FleetProblem:
        """Return the problem whose starts and goals are the cells nearest to places.

        Parameters
        ----------
        starts, goals : (n, 2) float64 array
            x, y of each robot [m] in the map frame.
        check : callable
            Called every few milliseconds; ends the work by raising.

        Raises
        ------
        InvalidInput
            The numbers of starts and goals differ, two robots share a cell, or there are too many robots for the map.
        StartOutsideMap, GoalOutsideMap
            A place is outside the map.
        StartOccupied, GoalOccupied
            A robot does not fit at a place, or there is no cell near it.
        NoValidPath
            A robot cannot reach its goal.
        """
        if len(starts) != len(goals):
            raise InvalidInput(f"there are {len(starts)} starts and {len(goals)} goals; give as many of both")
        if len(starts) * len(self.metric.roadmap) > MOST_DISTANCES:
            raise InvalidInput(
                f"{len(starts)} robots on {len(self.metric.roadmap)} cells are too many: their product may be "
                f"{MOST_DISTANCES}; plan for fewer robots, or on a part of the map"
            )
        first, last = self._cells(starts, "start"), self._cells(goals, "goal")
        try:
            return FleetProblem.of(self.metric.roadmap, first, last, check)
        except NoValidPath as error:
            text = "a smaller margin may open a way, or a goal in the same part of the map"
            raise NoValidPath(f"{error}: {text}") from error

    def _cells(self, places: NDArray[np.float64], what: str) -> NDArray[np.int64]:
        """Return row and column of the cell of each place, (n, 2) int64."""
        cells = np.array([self._cell(what, robot, x, y) for robot, (x, y) in enumerate(places.tolist())], np.int64)
        self._check_apart(cells, what)
        return self.metric.roadmap.cells[cells].astype(np.int64)

    def _cell(self, what: str, robot: int, x: float, y: float) -> int:
        """Return the cell of a place; errors name the robot."""
        outside, occupied = (StartOutsideMap, StartOccupied) if what == "start" else (GoalOutsideMap, GoalOccupied)
        name = f"the {what} of robot {robot}, {x:g}, {y:g},"
        cell = self.info.cell_of(x, y)
        if cell is None:
            raise outside(f"{name} is outside the map; give x, y in metres in the frame of the map")
        if self.to_lethal[cell] < np.float32(self.radius):
            cause = None if self.causes is None else self.causes(x, y)
            what_it_is = "an obstacle or unknown" if cause is None else cause.text
            text = f"is {self.to_lethal[cell]:.3g} m from {what_it_is}; a robot needs {self.radius:g} m"
            raise occupied(f"{name} {text}: move the {what}")
        try:
            return self.metric.nearest(x, y, WITHIN * self.metric.spacing)
        except PlanningError as error:
            text = f"has no cell within {WITHIN * self.metric.spacing:.3g} m; give a smaller margin or move the {what}"
            raise occupied(f"{name} {text}") from error

    def _check_apart(self, cells: NDArray[np.int64], what: str) -> None:
        order = np.argsort(cells, kind="stable")
        for k in np.nonzero(np.diff(cells[order]) == 0)[0][:1]:
            one, other = order[k], order[k + 1]
            x, y = self.metric.centres[cells[one]]
            raise InvalidInput(
                f"the {what}s of robots {one} and {other} are in one cell, at {x:.3f}, {y:.3f}; cells are "
                f"{self.metric.spacing:g} m wide: move one of them to another"
            )
