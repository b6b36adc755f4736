"""A map as searches from cell to cell want it: with a margin, and its weights in whole units."""

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
    """The costs of a map with a blocked cell more on each side, so that no kernel asks whether a neighbour exists.

    A cell (row, column) of the map is element (row + 1)·stride + column + 1 of the flat array. Rows fill whole words of
    64 cells.

    Parameters
    ----------
    costmap : Costmap
        Only read.
    allow_unknown : bool
        Whether unknown cells may be entered.
    check : callable
        Called at least every few milliseconds of work; what it raises ends the work.

    Attributes
    ----------
    shape : (rows, stride)
        Of the padded map.
    costs : (rows·stride,) uint8 array
    weights : (2, 256) int64 array
        Of cardinal and diagonal moves into cells of each cost, as in `ppaas.planners.units`; 0 is blocked.
    least, most : int
        Of the weights of cardinal and of diagonal moves, those of the cheapest and of the dearest move there is.
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
        """Bytes that it takes."""
        return self.costs.nbytes + self.weights.nbytes

    @property
    def grain(self) -> int:
        """How much estimates may differ and be taken from a queue in any order: an eighth of the cheapest move."""
        return self.least >> 3

    @property
    def dearest_path(self) -> int:
        """More than any path without a loop can weigh."""
        return self.most * self.costs.size

    def flat(self, cell: Cell) -> int:
        """Return which element a cell is."""
        return (cell[0] + 1) * self.shape[1] + cell[1] + 1
