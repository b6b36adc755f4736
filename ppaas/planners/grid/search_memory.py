"""Memory of A* and jump point search: the arrays of their bucket queue, and values of cells that are never reset."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.array_growth import doubled
from ppaas.planners.grid.kernels.bucket_ring import MARKS, RING_STATE, SHIFT, SLOT_BITS, SLOTS

INITIAL_CAPACITY = 1 << 12
"""Initial capacity [entries]."""


class BucketRing:
    """Arrays of `ppaas.planners.grid.kernels.bucket_ring`, which only kernels read and write.

    Parameters
    ----------
    span : int
        Largest difference between a key in the queue and the lowest one.
    grain : int
        Keys that differ by less may be popped in any order: fewer buckets use the cache better.
    room : int
        Least capacity [entries].
    extra : int
        Numbers that the search keeps in ``state``, behind the ring's numbers.
    """

    def __init__(self, span: int, grain: int, room: int, extra: int) -> None:
        self.heads = np.zeros(SLOTS, np.int32)
        self.marks = np.zeros(MARKS, np.uint64)
        self.pool = np.empty((max(room, INITIAL_CAPACITY) + 1, 2), np.int32)
        self.state = np.zeros(RING_STATE + extra, np.int64)
        self.state[SHIFT] = max(0, grain.bit_length() - 1, span.bit_length() - SLOT_BITS + 1)

    @property
    def nbytes(self) -> int:
        """Memory used [bytes]."""
        return self.heads.nbytes + self.marks.nbytes + self.pool.nbytes + self.state.nbytes

    def grow(self, check: Callable[[], None]) -> None:
        """Double the capacity; queued entries remain."""
        self.pool = doubled(self.pool, check)


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
