"""Padded map with integer weights, for A* and jump point search."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.costmap.costmap import Costmap
from ppaas.planners.ends import Cell
from ppaas.planners.grid.kernels.padding import pad
from ppaas.planners.units import unit_weights
from ppaas.planners.watch import proceed

SLICE_PADDED = 1 << 20
"""Cells copied between two checks: about 1 ms."""


class PaddedMap:
    """Costs of a map with a blocked margin of one cell, so that kernels need no bounds checks for neighbours.

    The cell (row, column) of the map is element (row + 1)·stride + column + 1 of the flat array. The stride is a
    multiple of 64, the bits of a word.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work; an exception from it ends the work.

    Attributes
    ----------
    shape : (rows, stride)
        Shape of the padded map.
    costs : (rows·stride,) uint8 array
        Costs of the cells.
    weights : (2, 256) int64 array
        Weights of cardinal and diagonal moves into cells of each cost, as in `ppaas.planners.units`; 0 is blocked.
    least : int
        Weight of the cheapest cardinal move on this map.
    most : int
        Weight of the most expensive diagonal move on this map.
    one_cost : bool
        Whether all free cells weigh the same.
    """

    def __init__(self, costmap: Costmap, *, allow_unknown: bool = True, check: Callable[[], None] = proceed) -> None:
        self.shape = costmap.info.height + 2, -(-(costmap.info.width + 2) // 64) * 64
        costs, occurring = np.empty(self.shape, np.uint8), np.zeros(256, np.bool_)
        rows = max(1, SLICE_PADDED // self.shape[1])
        for first in range(0, self.shape[0], rows):
            check()
            pad(costmap.data, costs, occurring, first, min(first + rows, self.shape[0]))
        self.costs = costs.ravel()
        self.weights = unit_weights(occurring, allow_unknown)
        entered: NDArray[np.int64] = self.weights[:, self.weights[0] > 0]
        self.least = int(entered[0].min()) if entered.size else 1
        self.most = int(entered[1].max()) if entered.size else 1
        self.one_cost = entered.shape[1] < 2

    @property
    def nbytes(self) -> int:
        """Memory used [bytes]."""
        return self.costs.nbytes + self.weights.nbytes

    @property
    def grain(self) -> int:
        """Bucket width of queues: an eighth of the cheapest move. Keys within it may be popped in any order."""
        return self.least >> 3

    @property
    def path_bound(self) -> int:
        """Upper bound of the weight of a path without a loop."""
        return self.most * self.costs.size

    def flat(self, cell: Cell) -> int:
        """Return the index of a cell in the flat array."""
        return (cell[0] + 1) * self.shape[1] + cell[1] + 1
