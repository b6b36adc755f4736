"""Checks against the costs of now, of which the index of the map knows nothing."""

import numpy as np
from numpy.typing import NDArray

from ppaas.cost_values import INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.kernel_cache.decorators import compiled

Bounds = tuple[int, int, int, int]


@compiled
def is_free_along(costs: NDArray[np.uint8], cells: NDArray[np.int32], allow_unknown: bool) -> bool:
    """Return whether a robot may take a path.

    Parameters
    ----------
    costs : (height, width) uint8 array
        Costs of the map with all that the robot sees.
    cells : (n, 2) int32 array
        Row and column of each cell of the path; each is a neighbour of the one before it.
    allow_unknown : bool
        Whether unknown cells are free.
    """
    for i in range(len(cells)):
        row, column = cells[i]
        # A diagonal move passes the corners of the two cells beside it; for other moves these are its ends.
        row_before, column_before = cells[max(i - 1, 0)]
        for cost in (costs[row, column], costs[row_before, column], costs[row, column_before]):
            if not _is_free(cost, allow_unknown):
                return False
    return True


@compiled
def opens(costs: NDArray[np.uint8], base: NDArray[np.uint8], window: Bounds, allow_unknown: bool) -> bool:
    """Return whether a cell is free that the map has blocked.

    Parameters
    ----------
    costs : (height, width) uint8 array
        Costs of the map with all that the robot sees.
    base : (height, width) uint8 array
        Costs of the map alone, read-only.
    window : (int, int, int, int)
        First row, end of the rows, first column and end of the columns of the cells to compare.
    allow_unknown : bool
        Whether unknown cells are free.
    """
    top, bottom, left, right = window
    opened = 0
    for row in range(top, bottom):
        for column in range(left, right):  # without branches, which LLVM turns into SIMD instructions
            opened |= _is_free(costs[row, column], allow_unknown) > _is_free(base[row, column], allow_unknown)
    return opened != 0


@compiled(forceinline=True)
def _is_free(cost: int, allow_unknown: bool) -> bool:
    return (cost < INSCRIBED_INFLATED_OBSTACLE) | (allow_unknown & (cost == NO_INFORMATION))


def warm() -> None:
    """Compile and call each kernel once."""
    costs = np.zeros((1, 1), np.uint8)
    is_free_along(costs, np.zeros((1, 2), np.int32), True)
    base = costs.copy()
    base.flags.writeable = False
    opens(costs, base, (0, 1, 0, 1), True)
