"""Values of all cells of a map, reused from search to search without being reset."""

import numpy as np
from numpy.typing import NDArray

LOWEST = -(1 << 62)
"""Lower bound of the values; the array is replaced before a search would go below it."""


class ReusableValues:
    """Array of values in which each search uses a separate range, below the range of the search before.

    A value in the array is therefore either of the current search or greater than any value that it writes, and the
    comparison "new value < old value" is also true for a cell that is reached for the first time. The array begins as
    zeros that the operating system maps on demand, so a search only pays for the cells that it touches.

    Parameters
    ----------
    shape : tuple
    span : int
        Number of distinct values that a search needs.
    """

    def __init__(self, shape: tuple[int, ...], span: int) -> None:
        self.values: NDArray[np.int64] = np.zeros(shape, np.int64)
        self.span = span + span % 2
        self._base = 0

    def begin(self) -> int:
        """Begin a search; return its base: the value of its source, which is even and the least that it writes."""
        self._base -= self.span
        if self._base < LOWEST:
            self.values = np.zeros(self.values.shape, np.int64)
            self._base = -self.span
        return self._base
