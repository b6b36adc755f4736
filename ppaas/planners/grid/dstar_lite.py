"""D* Lite: replans after changes of the map and moves of the robot, expanding only the affected cells."""

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell, Ends
from ppaas.planners.field.kernels.descent import descend
from ppaas.planners.field.kernels.layout import AT_GOAL, BLOCKED
from ppaas.planners.grid.kernels.dstar_lite import (
    COUNT,
    FAR,
    GOAL,
    MOVED,
    SIZE,
    START,
    STATE_SIZE,
    State,
    amend,
    repair,
)
from ppaas.planners.grid_planner import Found, GridPlanner
from ppaas.planners.kernels.moves import PAUSED, SETTLED, octile
from ppaas.planners.traits import Optimal, Traits
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, SCALE, blocking_weights, fixed_weights, neighbour_offsets, padded

# -- the cost field, which is repaired ---------------------------------------------------------------------------------

SLICE_CELLS = 1_500
"""Cells expanded or changed between two checks: about 1 ms, or 3 ms if the memory is newly allocated."""
SLICE_WALKED = 50_000
"""Cells of a path written between two checks."""
SLICE_SETUP = 1 << 15
"""Cells set up between two checks: 0.5 ms, or 4 ms if the system has to map the memory first."""
SLICE_COMPARED = 1 << 20
"""Cells compared with the last map between two checks: about 1 ms."""
MAX_MOVED = 1 << 51
"""Bound of k_m, in fixed point: beyond it the float64 keys of the heap may soon be inexact."""


class DStarLiteField:
    """Costs-to-go to one goal, final as far as the robot's path needs them.

    It uses 21 bytes per cell, and 20 more for each cell that was ever queued.

    Parameters
    ----------
    costmap : Costmap
        Only read; the field keeps a copy.
    goal : (row, column)
        A free cell on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work. An exception from it ends the work, which can be resumed.
    """

    def __init__(
        self, costmap: Costmap, goal: Cell, *, allow_unknown: bool = True, check: Callable[[], None] = proceed
    ) -> None:
        self.goal, self.shape = goal, costmap.info.shape
        self._stride = costmap.info.width + 2
        self._costs = padded(costmap.data, check).ravel()
        self._weights = blocking_weights(allow_unknown)
        self._offsets = neighbour_offsets(self._stride)
        self._least = fixed_weights()[:, 0].copy()
        size = self._costs.size
        self._field, self._ahead = np.empty(size, np.int64), np.empty(size, np.int64)
        for first in range(0, size, SLICE_SETUP):
            check()
            part = slice(first, first + SLICE_SETUP)
            self._field[part] = np.where(self._weights[0, self._costs[part]] > 0, FAR, BLOCKED)
            self._ahead[part] = FAR
        self._keys, self._cells = np.empty((size, 2)), np.empty(size, np.int32)
        self._places = np.zeros(size, np.int32)
        self._state = np.zeros(STATE_SIZE, np.int64)
        end = self._flat(goal)
        self._state[START] = self._state[GOAL] = end
        self._ahead[end] = AT_GOAL
        self._keys[1], self._cells[1], self._places[end], self._state[SIZE] = AT_GOAL, end, 1, 1

    @property
    def settled(self) -> int:
        """Number of expansions since construction; a cell expanded twice counts twice."""
        return int(self._state[COUNT])

    @property
    def worn(self) -> bool:
        """Whether the robot has moved so far that a new field is needed."""
        return bool(self._state[MOVED] > MAX_MOVED)

    def differing(self, costmap: Costmap, check: Callable[[], None] = proceed) -> NDArray[np.int64]:
        """Return the (n, 2) cells whose costs differ from the last map's; both have the same size."""
        height, width = self.shape
        inner = self._costs.reshape(height + 2, self._stride)[1:-1, 1:-1]
        rows, found = max(1, SLICE_COMPARED // width), []
        for first in range(0, height, rows):
            check()
            part = slice(first, first + rows)
            found.append(first * width + np.flatnonzero(inner[part] != costmap.data[part]))
        return np.stack(np.divmod(np.concatenate(found), width), axis=1)

    def amend(self, costmap: Costmap, changed: NDArray[np.int64], check: Callable[[], None] = proceed) -> None:
        """Update the costs of (n, 2) cells; the goal must remain free."""
        for first in range(0, len(changed), SLICE_CELLS):
            check()
            row, column = changed[first : first + SLICE_CELLS].T
            amend(*self._kernel_arguments(), (row + 1) * self._stride + column + 1, costmap.data[row, column])

    def reach(self, start: Cell, check: Callable[[], None] = proceed) -> bool:
        """Repair the field until the value of the robot's cell is final; return whether there is a path from it."""
        before, here = int(self._state[START]), self._flat(start)
        if self.settled:
            self._state[MOVED] += octile(before, here, self._stride, *self._least)
        self._state[START] = here
        outcome = PAUSED
        while outcome == PAUSED:
            check()
            outcome = repair(*self._kernel_arguments(), SLICE_CELLS)
        return bool(outcome == SETTLED and self.value < FAR)

    @property
    def value(self) -> int:
        """Cost-to-go from the robot's cell, in fixed point; `FAR` or more if there is no path."""
        return int(self._field[self._state[START]]) - AT_GOAL

    def path(self, check: Callable[[], None] = proceed) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path from the robot's cell, whose value must be final."""
        most = self.value // round(SCALE * NEUTRAL) + 1
        cells = np.empty((most, 2), np.int32)
        here = int(self._state[START])
        cells[0] = here // self._stride - 1, here % self._stride - 1
        count, before = 1, 0
        while count > before:
            check()
            before = count
            budget = min(SLICE_WALKED, most - count)
            count = descend(self._field, self._costs, self._stride, self._weights, cells, count, budget)
        return cells[:count].copy()

    def _kernel_arguments(self) -> State:
        return (
            self._field, self._ahead, self._costs, self._stride, self._weights, self._offsets, self._least,
            self._keys, self._cells, self._places, self._state,
        )  # fmt: skip

    def _flat(self, cell: Cell) -> int:
        return (cell[0] + 1) * self._stride + cell[1] + 1


# -- the planner -------------------------------------------------------------------------------------------------------

MAX_CHANGED = 1 / 16
"""Fraction of changed cells beyond which growing a new field is faster than updating the old one."""


class DStarLite(GridPlanner):
    """Keeps its cost field from plan to plan, as long as the goal and the size of the map are the same.

    It compares the map with the last one to find changed cells. Paths cost the same as with ``dijkstra``. The field
    of a plan that was cancelled or timed out is kept as well.
    """

    name: ClassVar[str] = "dstar_lite"
    purpose: ClassVar[str] = "Cheapest path again and again to one goal, while the map changes near the robot."
    traits: ClassVar[Traits] = Traits(optimal=Optimal.ALWAYS, incremental=True)

    def __init__(self, *, allow_unknown: bool = True, smooth: bool = False) -> None:
        super().__init__(allow_unknown=allow_unknown, smooth=smooth)
        self._field: DStarLiteField | None = None

    def search(self, costmap: Costmap, ends: Ends, *, threads: int, check: Callable[[], None]) -> Found:
        """Return the cells of a cheapest path; ``expanded`` counts the expansions of this plan only."""
        field = self._updated(costmap, ends, check)
        if field is None:
            field = self._field = DStarLiteField(costmap, ends.goal, allow_unknown=self.allow_unknown, check=check)
        before = field.settled
        reached = field.reach(ends.start, check)
        cells = field.path(check) if reached else np.empty((0, 2), np.int32)
        return Found(cells, field.settled - before)

    def _updated(self, costmap: Costmap, ends: Ends, check: Callable[[], None]) -> DStarLiteField | None:
        """Return the last field, updated to the current costs; None if a new one must be grown."""
        field = self._field
        if field is None or field.goal != ends.goal or field.shape != costmap.info.shape or field.worn:
            return None
        changed = field.differing(costmap, check)
        if len(changed) > MAX_CHANGED * costmap.data.size:
            return None
        field.amend(costmap, changed, check)
        return field
