"""Kernel: initialize the padded costs and the empty field, row by row."""

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.field.kernels.layout import BLOCKED, UNREACHED

Bytes = NDArray[np.uint8]
Field = NDArray[np.uint32]


@compiled
def _pad_row(source: Bytes, allow_unknown: bool, costs: Bytes, field: Field, row: int) -> None:
    height, width = source.shape
    costs[row, 0] = costs[row, width + 1] = 255
    field[row, 0] = field[row, width + 1] = BLOCKED
    if row in (0, height + 1):
        for column in range(1, width + 1):
            costs[row, column] = 255
            field[row, column] = BLOCKED
        return
    for column in range(width):
        cost = source[row - 1, column]
        costs[row, column + 1] = cost
        free = (cost < INSCRIBED_INFLATED_OBSTACLE) | ((cost == NO_INFORMATION) & allow_unknown)
        field[row, column + 1] = UNREACHED if free else np.uint32(BLOCKED)


@compiled
def pad_rows(source: Bytes, allow_unknown: bool, costs: Bytes, field: Field, first: int, last: int) -> None:
    """Initialize rows ``first`` to ``last`` of the padded arrays.

    Parameters
    ----------
    source : (height, width) uint8 array
        Costs of the map.
    allow_unknown : bool
        Whether unknown cells may be entered.
    costs : (height + 2, width + 2) uint8 array
        Out: costs with a margin.
    field : (height + 2, width + 2) uint32 array
        Out: `UNREACHED` or `BLOCKED`.
    first, last : int
        Range of padded rows, ``last`` excluded.
    """
    for row in range(first, last):
        _pad_row(source, allow_unknown, costs, field, row)


def warm() -> None:
    """Compile and call each kernel once."""
    source = np.zeros((1, 1), np.uint8)
    source.flags.writeable = False
    for cells in (source, np.zeros((1, 1), np.uint8)):
        pad_rows(cells, True, np.empty((3, 3), np.uint8), np.empty((3, 3), np.uint32), 0, 3)
