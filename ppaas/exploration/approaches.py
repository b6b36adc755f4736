"""Approaches to frontiers: poses on known free space from which a robot sees them, and the way there."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE
from ppaas.costmap.costmap import Costmap
from ppaas.errors import StartOccupied, StartOutsideMap
from ppaas.exploration.frontiers import Cells, Frontier
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED_THRESHOLD, GridMap
from ppaas.planners.ends import Cell, escape
from ppaas.planners.field.cost_field import CostField
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, passable

SIGHT = 0.75
"""Largest distance of a pose from a frontier whose own cells the robot cannot enter [m]."""

MOST_COST = 128
"""Cost of a pose from which an obstacle is 7 cm farther than it must be, by the usual parameters. Move Base sees
obstacles a little larger than they are on the map."""

_SAMPLES = 48
"""Cells of a frontier to which distances are computed."""

_TRIED = 12
"""Nearest cells of which one must see the frontier."""


@dataclass(frozen=True, slots=True)
class Approach:
    """Pose from which the robot sees a frontier.

    Parameters
    ----------
    frontier : Frontier
    pose : Pose2D
        In the map frame; its heading is into the unknown.
    seen : (2,) array
        The cell of the frontier that is nearest the pose, x, y [m].
    distance : float
        Cost of the path of the robot, as the length of a path through free space [m].
    """

    frontier: Frontier
    pose: Pose2D
    seen: NDArray[np.float64]
    distance: float

    @property
    def size(self) -> float:
        """Size of the frontier [m]."""
        return self.frontier.size


class Reach:
    """Cells that the robot can reach through known free space, with the costs of the paths.

    Parameters
    ----------
    grid : GridMap
        The map.
    costmap : Costmap
        The map, inflated for the robot.
    robot : Pose2D
        In the map frame. If its cell is not free, it first drives to the nearest one that is.
    check : callable
        Called every few milliseconds; an exception from it ends the work.

    Raises
    ------
    StartOutsideMap
        The map does not cover the pose.
    StartOccupied
        No free cell is near the robot.
    """

    def __init__(self, grid: GridMap, costmap: Costmap, robot: Pose2D, check: Callable[[], None] = proceed) -> None:
        self._grid, self._costmap = grid, costmap
        start = _start(costmap, robot, check)
        self._field = CostField(costmap, np.array([start]), allow_unknown=False, check=check)
        self._field.grow()

    def approaches(self, frontiers: Sequence[Frontier]) -> list[Approach]:
        """Return an approach to each frontier that has one, in the same order."""
        found = (self._approach(frontier) for frontier in frontiers)
        return [approach for approach in found if approach is not None]

    def _approach(self, frontier: Frontier) -> Approach | None:
        cells = frontier.cells
        costs = self._field.values_at(cells)
        within = np.isfinite(costs)
        clear = within & self._is_clear(cells)
        if clear.any():
            return self._to_middle(frontier, clear, costs)
        beside = self._from_beside(frontier)
        return self._to_middle(frontier, within, costs) if beside is None and within.any() else beside

    def _is_clear(self, cells: Cells) -> NDArray[np.bool_]:
        """Return which of (n, 2) cells stay free if an obstacle is seen slightly larger than on the map."""
        clear: NDArray[np.bool_] = self._costmap.data[cells[:, 0], cells[:, 1]] < MOST_COST
        return clear

    def _to_middle(self, frontier: Frontier, usable: NDArray[np.bool_], costs: NDArray[np.float64]) -> Approach:
        cells = frontier.cells[usable]
        best = self._middle(cells)
        return self._to(frontier, cells[best], cells[best], float(costs[usable][best]))

    def _middle(self, cells: Cells) -> int:
        """Return the index of the cell nearest to the mean of all cells; a low cost makes up for some distance."""
        off = np.hypot(*(cells - cells.mean(axis=0)).T) * self._costmap.info.resolution
        return int(np.argmin(off + self._costmap.data[cells[:, 0], cells[:, 1]] / INSCRIBED_INFLATED_OBSTACLE))

    def _from_beside(self, frontier: Frontier) -> Approach | None:
        """Return an approach from the nearest cells that the robot can reach and that see the frontier."""
        most = SIGHT / self._costmap.info.resolution
        sampled = frontier.cells[np.linspace(0, len(frontier.cells) - 1, _SAMPLES).astype(np.int64)]
        around = self._window(sampled, int(most))
        costs = self._field.values_at(around)
        usable = np.isfinite(costs) & self._is_clear(around)
        around, costs = around[usable], costs[usable]
        if not len(around):
            return None
        apart = np.hypot(*(around[:, None] - sampled[None]).transpose(2, 0, 1))
        seen, nearest = np.argmin(apart, axis=1), apart.min(axis=1)
        for index in np.argsort(nearest, kind="stable")[:_TRIED].tolist():
            cell, target = around[index], sampled[seen[index]]
            if nearest[index] <= most and self._sees(cell, target):
                return self._to(frontier, cell, target, float(costs[index]))
        return None

    def _window(self, cells: Cells, margin: int) -> Cells:
        low = np.maximum(cells.min(axis=0) - margin, 0)
        high = np.minimum(cells.max(axis=0) + margin + 1, self._costmap.info.shape)
        within: Cells = np.argwhere(np.ones(high - low, np.bool_)) + low
        return within

    def _sees(self, cell: Cells, target: Cells) -> bool:
        steps = 2 * int(np.abs(target - cell).max()) + 1
        line = np.rint(np.linspace(cell, target, steps)).astype(np.int64)
        values = self._grid.data[line[:, 0], line[:, 1]]
        return bool(((values >= FREE) & (values < OCCUPIED_THRESHOLD)).all())

    def _to(self, frontier: Frontier, cell: Cells, seen: Cells, cost: float) -> Approach:
        info = self._costmap.info
        x, y = info.to_world(cell).tolist()
        pose = Pose2D(x, y, frontier.heading)
        return Approach(frontier, pose, info.to_world(seen), cost * info.resolution / NEUTRAL)


def _start(costmap: Costmap, robot: Pose2D, check: Callable[[], None]) -> Cell:
    cell = costmap.info.cell_of(robot.x, robot.y)
    if cell is None:
        raise StartOutsideMap(f"the robot at ({robot.x:.2f}, {robot.y:.2f}) is outside the map")
    path = escape(costmap, cell, passable(allow_unknown=False), check)
    if not len(path):
        raise StartOccupied(
            f"no free cell of the map is near the robot at ({robot.x:.2f}, {robot.y:.2f}): drive it to a free place"
        )
    row, column = path[-1].tolist()
    return row, column
