"""Kernel: copy a map with a blocked margin around it, and note which costs it has."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.cost_values import LETHAL_OBSTACLE

Bytes = NDArray[np.uint8]


@njit(cache=True, nogil=True, error_model="numpy")
def pad(source: Bytes, costs: Bytes, occurring: NDArray[np.bool_], first: int, last: int) -> None:
    """Fill rows ``first`` to ``last`` of the padded map.

    Parameters
    ----------
    source : (height, width) uint8 array
        Costs of the map.
    costs : (height + 2, stride) uint8 array
        Out: the same with a lethal margin; stride is width + 2 or more.
    occurring : (256,) bool array
        Set for each cost met.
    first, last : int
        Padded rows to fill, ``last`` excluded.
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
    """Compile and call the kernel once, for maps that may be written to and for those that may not."""
    source = np.zeros((1, 1), np.uint8)
    source.flags.writeable = False
    for cells in (source, np.zeros((1, 1), np.uint8)):
        pad(cells, np.empty((3, 3), np.uint8), np.zeros(256, np.bool_), 0, 3)
