"""Map preparation of jump point search."""

from collections.abc import Callable

import numpy as np

from ppaas.costmap.costmap import Costmap
from ppaas.planners.grid.kernels.jump_planes import mark_cells, mark_jumps, turn
from ppaas.planners.grid.padded_map import PaddedMap
from ppaas.planners.watch import proceed

PLANES = 5
"""Number of bit planes; see `ppaas.planners.grid.kernels.jump_planes`."""

SLICE_MARKED = 1 << 19
"""Cells whose bits are set between two checks: about 3 ms."""


class JumpMap:
    """Padded map, and bit planes of the ends of jumps along its rows and columns.

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
    costmap : Costmap
    allow_unknown : bool
    padded : PaddedMap
    rows, columns : (5, lines, words) uint64 array
        The bit planes, as in `ppaas.planners.grid.kernels.jump_planes`.
    """

    def __init__(self, costmap: Costmap, *, allow_unknown: bool = True, check: Callable[[], None] = proceed) -> None:
        self.costmap, self.allow_unknown = costmap, allow_unknown
        self.padded = PaddedMap(costmap, allow_unknown=allow_unknown, check=check)
        height, width = self.padded.shape
        words = width // 64, -(-height // 64)
        split = PLANES * height * words[0]
        self.planes = np.zeros(split + PLANES * width * words[1], np.uint64)
        self.rows = self.planes[:split].reshape(PLANES, height, words[0])
        self.columns = self.planes[split:].reshape(PLANES, width, words[1])
        costs = self.padded.costs.reshape(self.padded.shape)
        weights, one_cost = self.padded.weights[0], self.padded.one_cost
        for first, last in _slices(height, width):
            check()
            mark_cells(costs, weights, one_cost, self.rows, first, last)
        for word in range(self.columns.shape[2]):
            check()
            turn(self.rows, self.columns, word, word + 1)
        for planes in (self.rows, self.columns):
            for first, last in _slices(planes.shape[1], 64 * planes.shape[2]):
                check()
                mark_jumps(planes, first, last)

    def query(self, base: int, target: int) -> tuple[int, ...]:
        """Return the ``query`` argument of the kernel `ppaas.planners.grid.kernels.jps`."""
        height, stride = self.padded.shape
        column = 64 * self.columns.shape[2]
        return (
            base, *divmod(target, stride), stride, self.padded.least,
            height * stride, 64 * self.rows.size, column, column * stride,
        )  # fmt: skip

    @property
    def nbytes(self) -> int:
        """Memory used [bytes]."""
        return self.padded.nbytes + self.planes.nbytes


def _slices(lines: int, length: int) -> list[tuple[int, int]]:
    at_once = max(1, SLICE_MARKED // length)
    return [(first, min(first + at_once, lines)) for first in range(0, lines, at_once)]
