"""Distinct numbers of large arrays. ``np.unique`` hashes them, which takes five times as long as sorting."""

import numpy as np
from numpy.typing import NDArray

DENSE = 1 << 27
"""Largest number for which there is a flag each."""


def distinct(numbers: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """Return the distinct numbers, from 0 to ``count`` − 1, in ascending order."""
    if count <= DENSE:
        flags = np.zeros(count, np.bool_)
        flags[numbers] = True
        return np.flatnonzero(flags)
    ordered = np.sort(numbers)
    return ordered[np.r_[True, ordered[1:] != ordered[:-1]]] if len(ordered) else ordered
