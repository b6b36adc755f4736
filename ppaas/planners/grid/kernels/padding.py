"""Kernel: copy a map with a blocked margin, and find out which costs occur in it."""

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE
from ppaas.kernel_cache.decorators import compiled

Bytes = NDArray[np.uint8]


@compiled
def pad(source: Bytes, costs: Bytes, occurring: NDArray[np.bool_], first: int, last: int) -> None:
    """Fill rows ``first`` to ``last`` of the padded map.

    Parameters
    ----------
    source : (height, width) uint8 array
        Costs of the map.
    costs : (height + 2, stride) uint8 array
        Out: costs with a lethal margin; stride is at least width + 2.
    occurring : (256,) bool array
        Out: set to true for each cost that occurs.
    first, last : int
        Range of padded rows, ``last`` excluded.
    """
    height, width = source.shape
    for row in range(first, last):
        costs[row, 0] = LETHAL_OBSTACLE
        costs[row, width + 1 :] = LETHAL_OBSTACLE
        if row in (0, height + 1):
            costs[row, :] = LETHAL_OBSTACLE
            continue
        for column in range(width):
            cost = source[row - 1, column]
            costs[row, column + 1] = cost
            occurring[cost] = True


def warm() -> None:
    """Compile and call the kernel once, for writable and for read-only maps."""
    source = np.zeros((1, 1), np.uint8)
    source.flags.writeable = False
    for cells in (source, np.zeros((1, 1), np.uint8)):
        pad(cells, np.empty((3, 3), np.uint8), np.zeros(256, np.bool_), 0, 3)
