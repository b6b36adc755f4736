"""navfn: the default planner of ROS, for comparison and for robots that are tuned to its paths."""

import math
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.errors import InvalidPlanner
from ppaas.planners.ends import Cell, Ends
from ppaas.planners.grid.kernels.navfn import (
    BEYOND,
    COUNT,
    CURRENT,
    FOUND,
    FULL,
    NEUTRAL,
    NEXT,
    PAUSED,
    REACHED,
    STATE_SIZE,
    TOO_FAR,
    expand,
)
from ppaas.planners.grid.kernels.navfn_walk import walk
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.traits import Traits
from ppaas.planners.watch import proceed
from ppaas.planners.weights import exact_weights, passable

# -- potentials that rise from a goal, and the descent along them ------------------------------------------------------

SLICE_CELLS = 50_000
"""Cells expanded between two checks: about 2 ms."""
SLICE_SETUP = 1 << 19
"""Cells set up between two checks."""
SLICE_STEPS = 20_000
"""Steps of the descent between two checks."""

INITIAL_CAPACITY = 1 << 12
"""Initial capacity of each buffer [cells]."""

FIRST_THRESHOLD = 254.0
"""Initial threshold of the priority: navfn's ``COST_OBS``."""


def byte_weights() -> NDArray[np.uint8]:
    """Return the (256,) weight of each cost: the other planners' weights, rounded down to a byte as in navfn."""
    return np.minimum(exact_weights(), 253.0).astype(np.uint8)


class NavigationFunction:
    """Potential of each cell, grown from a goal in slices.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    goal : (row, column)
        A free cell on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work; an exception from it ends the work.
    """

    def __init__(
        self, costmap: Costmap, goal: Cell, *, allow_unknown: bool = True, check: Callable[[], None] = proceed
    ) -> None:
        self._check = check
        height, width = costmap.info.shape
        self._shape, self._goal = (height + 2, width + 2), goal
        weights, blocked = byte_weights(), ~passable(allow_unknown)
        crossing, waiting = np.empty(self._shape, np.uint8), np.ones(self._shape, np.bool_)
        potentials = np.empty(self._shape, np.float32)
        rows = max(1, SLICE_SETUP // self._shape[1])
        for first in range(0, self._shape[0], rows):
            check()
            last = min(first + rows, height)
            crossing[first + 1 : last + 1, 1:-1] = weights[costmap.data[first:last]]
            waiting[first + 1 : last + 1, 1:-1] = blocked[costmap.data[first:last]]
            potentials[first : first + rows] = np.inf
        crossing[[0, -1]] = crossing[:, [0, -1]] = weights[-1]
        self._weights, self._waiting, self._potentials = crossing.ravel(), waiting.ravel(), potentials.ravel()
        self._threshold = np.array([FIRST_THRESHOLD], np.float32)
        self._buffers = np.empty((3, INITIAL_CAPACITY), np.uint32)
        self._state = np.zeros(STATE_SIZE, np.int64)
        self._state[[CURRENT, NEXT, BEYOND]] = range(3)
        self._seed(self._flat(goal))

    def _seed(self, goal: int) -> None:
        self._potentials[goal] = 0.0
        around = np.array((goal + 1, goal - 1, goal - self._shape[1], goal + self._shape[1]))
        around = around[~self._waiting[around]]
        self._waiting[around] = True
        self._buffers[0, : len(around)] = around
        self._state[COUNT] = len(around)

    @property
    def reached(self) -> int:
        """Number of cells that have a potential."""
        return int(self._state[REACHED]) + 1

    def potentials(self) -> NDArray[np.float32]:
        """Return the (height, width) potentials; infinite if blocked or not reached."""
        return self._potentials.reshape(self._shape)[1:-1, 1:-1]

    def grow(self, target: Cell | None = None, *, astar: bool = False) -> bool:
        """Grow the potentials until ``target`` is reached, or over the whole map.

        Like navfn it stops as soon as the target is reached, although its potential could still fall.

        Parameters
        ----------
        target : (row, column), optional
            A free cell on the map.
        astar : bool
            Whether to add the straight distance to the target to the priority of cells; requires a target.

        Returns
        -------
        bool
            Whether ``target`` can be reached; true without a target.

        Raises
        ------
        InvalidPlanner
            The path is too long for potentials in single precision.
        """
        pull = 0.0
        if astar and target is not None:
            pull = float(NEUTRAL)
            self._threshold += pull * math.dist(target, self._goal)
        wanted = -1 if target is None else self._flat(target)
        while True:
            self._check()
            outcome = expand(
                self._potentials, self._weights, self._waiting, self._shape[1], self._buffers, self._state,
                self._threshold, wanted, np.float32(pull), SLICE_CELLS,
            )  # fmt: skip
            if outcome == FULL:
                self._buffers = np.concatenate((self._buffers, np.empty_like(self._buffers)), axis=1)
            elif outcome == TOO_FAR:
                raise InvalidPlanner("the path is too long for navfn's potentials; choose dijkstra or another planner")
            elif outcome != PAUSED:
                return outcome == FOUND or target is None

    def walk_from(self, cell: Cell) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Descend the gradient from a reached cell.

        Returns
        -------
        cells : (n, 2) int32 array
            Row, column of the crossed cells, each a neighbour of the one before; two cardinal moves that can be
            replaced by a diagonal one are.
        points : (m, 2) float64 array
            Row, column of each step, with fractions; the first and the last are the centres of ``cell`` and the goal.
        """
        place, stay, goal = np.array(cell, np.float64) + 1.0, 0, self._flat(self._goal)
        cells, points, here = list[NDArray[np.int32]](), list[NDArray[np.float64]](), None
        while here != self._goal:
            self._check()
            through, steps = np.empty((SLICE_STEPS, 2), np.int32), np.empty((SLICE_STEPS, 2))
            count, taken, stayed = walk(self._potentials, self._shape[1], goal, place, stay, through, steps)
            again = tuple(through[0].tolist()) == here
            stay = int(stayed)
            cells.append(through[int(again) : count])
            points.append(steps[:taken])
            here = tuple(through[count - 1].tolist())
        return np.concatenate(cells), np.concatenate(points)

    def _flat(self, cell: Cell) -> int:
        return (cell[0] + 1) * self._shape[1] + cell[1] + 1


# -- the planner -------------------------------------------------------------------------------------------------------


class NavFn(GridPlanner):
    """Grows a navigation function until it reaches the start, and follows its gradient to the goal, on one thread.

    The algorithm is ``NavFn`` of ROS's ``navfn`` and Nav2's ``nav2_navfn_planner``: integer weights, potentials
    interpolated between neighbours, steps of half a cell down the gradient. Four defects are fixed: buffers grow, where
    navfn drops cells beyond 10 000; cells at the edge of the map may be entered; the path cuts no corners; and where
    the gradient vanishes the path continues from cell to cell instead of failing.

    ``cells`` are those that the path crosses, except where it only cuts their corner; poses are half a cell apart. In
    the open the path is short and smooth, but not the cheapest: it is found before all potentials are final.

    Parameters
    ----------
    allow_unknown : bool
        Whether paths may cross unknown cells, which then weigh 253.
    use_astar : bool
        Whether to expand cells near the start first. Fewer cells are reached, and the path is up to 10 % longer.
    """

    name: ClassVar[str] = "navfn"
    purpose: ClassVar[str] = "Smooth path as ROS's own planner finds it, on one thread; for comparison."
    traits: ClassVar[Traits] = Traits(any_angle=True)

    def __init__(self, *, allow_unknown: bool = True, use_astar: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown)
        self.use_astar = use_astar

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells and the points between two ends.

        Raises
        ------
        InvalidPlanner
            The path is too long for navfn's potentials in single precision.
        """
        function = NavigationFunction(costmap, ends.goal, allow_unknown=self.allow_unknown, check=check)
        if not function.grow(ends.start, astar=self.use_astar):
            return Found(np.empty((0, 2), np.int32), function.reached)
        cells, points = function.walk_from(ends.start)
        return Found(cells, function.reached, points)
