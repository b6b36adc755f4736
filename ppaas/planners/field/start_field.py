"""The field of costs-to-come: what it costs to get from one start to each cell of a map."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.array_growth import doubled
from ppaas.planners.ends import Cell
from ppaas.planners.field.kernels.start_propagation import BLOCKED, FULL, PAUSED, STATE_SIZE, WAITING, leave
from ppaas.planners.padding import padded
from ppaas.planners.watch import proceed
from ppaas.planners.weights import exact_weights, passable

SLICE_CELLS = 50_000
"""Cells worked off between two checks: about 3 ms."""
SLICE_LAID = 1 << 20
"""Cells set up between two checks."""
FIRST_ROOM = 1 << 12
"""Cells that the list has room for to begin with."""


class StartField:
    """A field that grows from its start outward, in slices, on one thread.

    A move weighs what the cell nearer to the start weighs (see `ppaas.planners.path`). So this is no `CostField` of
    the start, in which a move would weigh what the other cell weighs. Values are the sums of the weights in float64.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    start : (row, column)
        A free cell on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work; what it raises ends the work.
    """

    def __init__(
        self, costmap: Costmap, start: Cell, *, allow_unknown: bool = True, check: Callable[[], None] = proceed
    ) -> None:
        self._check = check
        height, width = costmap.info.shape
        self._stride = width + 2
        free = passable(allow_unknown)
        self._weights = np.where(free, exact_weights(), np.inf)
        fresh = np.where(free, np.inf, BLOCKED)
        values = np.full((height + 2, self._stride), BLOCKED)
        rows = max(1, SLICE_LAID // width)
        for first in range(0, height, rows):
            check()
            last = min(first + rows, height)
            values[first + 1 : last + 1, 1:-1] = fresh[costmap.data[first:last]]
        self._costs, self._values = padded(costmap.data, check).ravel(), values.ravel()
        self._waiting, self._state = np.empty(FIRST_ROOM, np.uint32), np.zeros(STATE_SIZE, np.int64)
        at = (start[0] + 1) * self._stride + start[1] + 1
        self._values[at] = 0.0
        self._waiting[0], self._state[WAITING] = at, 1

    def grow(self, targets: NDArray[np.integer]) -> NDArray[np.float64]:
        """Let it grow until the values of (m, 2) cells are final, and return them; infinite where no way leads."""
        wanted = (targets[:, 0].astype(np.int64) + 1) * self._stride + targets[:, 1] + 1
        least = float(self._weights.min())
        outcome = PAUSED
        while outcome in (PAUSED, FULL):
            self._check()
            outcome = leave(
                self._values, self._costs, self._stride, self._weights, least,
                self._waiting, self._state, wanted, SLICE_CELLS,
            )  # fmt: skip
            if outcome == FULL:
                self._waiting = doubled(self._waiting, self._check)
        values: NDArray[np.float64] = self._values[wanted]
        return values
