"""Arrays of the bucket queue of A* and jump point search, and their growth."""

from collections.abc import Callable

import numpy as np

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
