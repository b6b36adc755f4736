"""Values of all cells of a map, all unreached again at the beginning of each search without being written to."""

import numpy as np
from numpy.typing import NDArray

LOWEST = -(1 << 62)
"""Below this no search counts."""


class FreshValues:
    """An array of zeros, in which each search counts in a range of its own, below that of the search before.

    So what a search finds written is either of itself or more than anything it will write, and "is the new value
    less?" alone tells that a cell is reached for the first time. Where the system gives memory as it is touched, a
    search pays for what it touches.

    Parameters
    ----------
    shape : tuple
    span : int
        How many values a search needs.
    """

    def __init__(self, shape: tuple[int, ...], span: int) -> None:
        self.values: NDArray[np.int64] = np.zeros(shape, np.int64)
        self.span = span + span % 2
        self._base = 0

    def begin(self) -> int:
        """Begin a search; return the value of its source, which is even and the least that it will write."""
        self._base -= self.span
        if self._base < LOWEST:
            self.values = np.zeros(self.values.shape, np.int64)
            self._base = -self.span
        return self._base
