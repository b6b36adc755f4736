"""A field of costs-to-go that is kept right while the map changes and the robot moves."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell
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
from ppaas.planners.kernels.moves import PAUSED, SETTLED, octile
from ppaas.planners.padding import blocking_weights, neighbour_offsets, padded
from ppaas.planners.watch import proceed
from ppaas.planners.weights import NEUTRAL, SCALE, fixed_weights

SLICE_CELLS = 1_500
"""Cells worked off, or changed, between two checks: about 1 ms, or 3 where all that they touch is new memory."""
SLICE_WALKED = 50_000
"""Cells walked along between two checks."""
SLICE_LAID = 1 << 15
"""Cells laid out between two checks: half a millisecond, or 4 where the system has to find the memory first."""
SLICE_COMPARED = 1 << 20
"""Cells compared with those of last time between two checks: about 1 ms."""
MOST_MOVED = 1 << 51
"""Once the robot has moved as far, sums may soon not be exact in the keys of the heap."""


class LivingField:
    """Costs-to-go to one goal, right as far as the robot's way is concerned.

    It takes 21 bytes a cell, and 20 more for each cell that ever waited.

    Parameters
    ----------
    costmap : Costmap
        Only read; a copy is kept.
    goal : (row, column)
        A free cell on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work; what it raises ends the work, which may be taken up again.
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
        for first in range(0, size, SLICE_LAID):
            check()
            part = slice(first, first + SLICE_LAID)
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
        """How many cells were worked off since it was made; one that was so twice counts twice."""
        return int(self._state[COUNT])

    @property
    def worn(self) -> bool:
        """Whether the robot has moved so far in it that another should be made."""
        return bool(self._state[MOVED] > MOST_MOVED)

    def differing(self, costmap: Costmap, check: Callable[[], None] = proceed) -> NDArray[np.int64]:
        """Return the (n, 2) cells that have other costs than before in a map of the same size."""
        height, width = self.shape
        inner = self._costs.reshape(height + 2, self._stride)[1:-1, 1:-1]
        rows, found = max(1, SLICE_COMPARED // width), []
        for first in range(0, height, rows):
            check()
            part = slice(first, first + rows)
            found.append(first * width + np.flatnonzero(inner[part] != costmap.data[part]))
        return np.stack(np.divmod(np.concatenate(found), width), axis=1)

    def amend(self, costmap: Costmap, changed: NDArray[np.int64], check: Callable[[], None] = proceed) -> None:
        """Take over the costs of (n, 2) cells; the goal must stay free."""
        for first in range(0, len(changed), SLICE_CELLS):
            check()
            row, column = changed[first : first + SLICE_CELLS].T
            amend(*self._everything(), (row + 1) * self._stride + column + 1, costmap.data[row, column])

    def reach(self, start: Cell, check: Callable[[], None] = proceed) -> bool:
        """Make the value of the cell final in which the robot stands now; return whether a way leads from there."""
        before, here = int(self._state[START]), self._flat(start)
        if self.settled:
            self._state[MOVED] += octile(before, here, self._stride, *self._least)
        self._state[START] = here
        outcome = PAUSED
        while outcome == PAUSED:
            check()
            outcome = repair(*self._everything(), SLICE_CELLS)
        return bool(outcome == SETTLED and self.value < FAR)

    @property
    def value(self) -> int:
        """The cost-to-go from where the robot stands, in fixed point; `FAR` or more if no way leads from there."""
        return int(self._field[self._state[START]]) - AT_GOAL

    def path(self, check: Callable[[], None] = proceed) -> NDArray[np.int32]:
        """Return the (n, 2) cells of a cheapest path from where the robot stands; its value must be final."""
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

    def _everything(self) -> State:
        """Return what the kernels take first, all of them alike."""
        return (
            self._field, self._ahead, self._costs, self._stride, self._weights, self._offsets, self._least,
            self._keys, self._cells, self._places, self._state,
        )  # fmt: skip

    def _flat(self, cell: Cell) -> int:
        return (cell[0] + 1) * self._stride + cell[1] + 1
