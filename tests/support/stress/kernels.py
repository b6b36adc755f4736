"""Two small parallel kernels, one like a planner's and one like a controller's."""

import numba
import numpy as np
from numpy.typing import NDArray


@numba.njit(parallel=True, nogil=True, cache=True)
def relax(grid: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return each cell as one more than the least of its neighbours above and below and itself."""
    out = np.empty_like(grid)
    height, width = grid.shape
    for row in numba.prange(height):
        up, down = max(row - 1, 0), min(row + 1, height - 1)
        for column in range(width):
            out[row, column] = 1.0 + min(grid[row, column], grid[up, column], grid[down, column])
    return out


@numba.njit(parallel=True, nogil=True, cache=True)
def roll_out(speeds: NDArray[np.float64], steps: int) -> float:
    """Return the sum of how far each speed leads in so many steps of 0.1 s."""
    total = 0.0
    for i in numba.prange(speeds.size):
        x = 0.0
        for _ in range(steps):
            x += 0.5 * speeds[i]
        total += x
    return total


def warm() -> None:
    relax(np.ones((4, 4)))
    roll_out(np.ones(4), 2)
