"""What can be reached from where."""

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.kernels.components import flood


def reachable(free: NDArray[np.bool_], row: int, column: int) -> NDArray[np.bool_]:
    """Return the cells that can be reached from one by moves to its eight neighbours.

    A diagonal move needs both cells beside it to be free, so it never reaches what moves along the axes would not.

    Parameters
    ----------
    free : (height, width) bool array
        Where the centre of the robot may be.
    row, column : int
        Where it is.

    Returns
    -------
    (height, width) bool array
        All false where the robot stands in a cell that is not free.

    Raises
    ------
    InvalidMap
        ``free`` is not a grid of bools.
    InvalidInput
        The cell lies outside the grid.
    """
    if free.ndim != 2 or free.dtype != np.bool_:
        raise InvalidMap(f"expected rows and columns of bools, got {free.dtype} of {free.shape}")
    height, width = free.shape
    if not (0 <= row < height and 0 <= column < width):
        raise InvalidInput(f"cell ({row}, {column}) lies outside the {height} rows and {width} columns of the grid")
    return flood(np.ascontiguousarray(free).view(np.uint8), row, column).view(np.bool_)
