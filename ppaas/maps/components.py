"""Connected components of free space."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.kernels.components import flood


def reachable(free: NDArray[np.bool_], row: int, column: int) -> NDArray[np.bool_]:
    """Return the cells that can be reached from a cell by moves to the eight neighbours.

    A diagonal move requires both adjacent cells to be free. Therefore diagonal moves reach no cell that moves along the
    axes do not.

    Parameters
    ----------
    free : (height, width) bool array
        Cells in which the centre of the robot may be.
    row, column : int
        Cell of the robot.

    Returns
    -------
    (height, width) bool array
        Reachable cells; all false if the robot's cell is not free.

    Raises
    ------
    InvalidMap
        ``free`` is not a two-dimensional array of bools.
    InvalidInput
        The cell is outside the grid.
    """
    if free.ndim != 2 or free.dtype != np.bool_:
        raise InvalidMap(f"expected a two-dimensional array of bools, not {free.dtype} of shape {free.shape}")
    height, width = free.shape
    if not (0 <= row < height and 0 <= column < width):
        raise InvalidInput(f"cell ({row}, {column}) is outside the grid of {height} rows and {width} columns")
    return flood(np.ascontiguousarray(free).view(np.uint8), row, column).view(np.bool_)
