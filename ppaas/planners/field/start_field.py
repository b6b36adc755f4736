"""Field of costs-to-come: the cost of the cheapest path from one start to each cell of a map."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.array_growth import doubled
from ppaas.planners.ends import Cell
from ppaas.planners.field.kernels.start_propagation import BLOCKED, FULL, PAUSED, STATE_SIZE, WAITING, grow_from_start
from ppaas.planners.watch import proceed
from ppaas.planners.weights import exact_weights, padded, passable

SLICE_CELLS = 50_000
"""Cells expanded between two checks: about 3 ms."""
SLICE_SETUP = 1 << 20
"""Cells set up between two checks."""
INITIAL_CAPACITY = 1 << 12
"""Initial capacity of the list of open cells."""


class StartField:
    """Field that grows from a start outward, in slices, on one thread.

    A move weighs as much as the cell nearer to the start (see `ppaas.planners.path`). In a `CostField` grown from the
    start it would weigh as much as the other cell. Values are sums of weights in float64.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    start : (row, column)
        A free cell on the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work; an exception from it ends the work.
    """

    def __init__(
        self, costmap: Costmap, start: Cell, *, allow_unknown: bool = True, check: Callable[[], None] = proceed
    ) -> None:
        self._check = check
        height, width = costmap.info.shape
        self._stride = width + 2
        free = passable(allow_unknown)
        self._weights = np.where(free, exact_weights(), np.inf)
        initial = np.where(free, np.inf, BLOCKED)
        values = np.full((height + 2, self._stride), BLOCKED)
        rows = max(1, SLICE_SETUP // width)
        for first in range(0, height, rows):
            check()
            last = min(first + rows, height)
            values[first + 1 : last + 1, 1:-1] = initial[costmap.data[first:last]]
        self._costs, self._values = padded(costmap.data, check).ravel(), values.ravel()
        self._waiting, self._state = np.empty(INITIAL_CAPACITY, np.uint32), np.zeros(STATE_SIZE, np.int64)
        at = (start[0] + 1) * self._stride + start[1] + 1
        self._values[at] = 0.0
        self._waiting[0], self._state[WAITING] = at, 1

    def grow(self, targets: NDArray[np.integer]) -> NDArray[np.float64]:
        """Grow the field until the values of (m, 2) cells are final, and return them; infinite without a path."""
        wanted = (targets[:, 0].astype(np.int64) + 1) * self._stride + targets[:, 1] + 1
        least = float(self._weights.min())
        outcome = PAUSED
        while outcome in (PAUSED, FULL):
            self._check()
            outcome = grow_from_start(
                self._values, self._costs, self._stride, self._weights, least,
                self._waiting, self._state, wanted, SLICE_CELLS,
            )  # fmt: skip
            if outcome == FULL:
                self._waiting = doubled(self._waiting, self._check)
        values: NDArray[np.float64] = self._values[wanted]
        return values
