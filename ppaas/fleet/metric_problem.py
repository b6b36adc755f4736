"""Metric problem: starts and goals in metres, as a problem on the metric roadmap of a map."""

from collections.abc import Callable
from dataclasses import dataclass

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
from ppaas.fleet.metric_roadmap import MetricRoadmap
from ppaas.fleet.problem import FleetProblem
from ppaas.maps.grid import GridInfo
from ppaas.planners.watch import proceed

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
