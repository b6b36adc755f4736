"""The queue of searches from cell to cell: its arrays, and how they grow."""

from collections.abc import Callable

import numpy as np

from ppaas.planners.array_growth import doubled
from ppaas.planners.grid.kernels.bucket_ring import MARKS, RING_STATE, SHIFT, SLOT_BITS, SLOTS

FIRST_ROOM = 1 << 12
"""Entries that there is room for to begin with."""


class KeyRing:
    """The arrays of `ppaas.planners.grid.kernels.bucket_ring`, which only kernels read and write.

    Parameters
    ----------
    span : int
        How far above the lowest key another may be.
    grain : int
        Keys that differ by less need not come out in order: the fewer buckets, the nearer they lie in memory.
    room : int
        Entries that there must be room for.
    extra : int
        Numbers that a search keeps in the state, behind those of the ring.
    """

    def __init__(self, span: int, grain: int, room: int, extra: int) -> None:
        self.heads = np.zeros(SLOTS, np.int32)
        self.marks = np.zeros(MARKS, np.uint64)
        self.pool = np.empty((max(room, FIRST_ROOM) + 1, 2), np.int32)
        self.state = np.zeros(RING_STATE + extra, np.int64)
        self.state[SHIFT] = max(0, grain.bit_length() - 1, span.bit_length() - SLOT_BITS + 1)

    @property
    def nbytes(self) -> int:
        """Bytes that it takes."""
        return self.heads.nbytes + self.marks.nbytes + self.pool.nbytes + self.state.nbytes

    def grow(self, check: Callable[[], None]) -> None:
        """Double the room; what is in the queue stays in it."""
        self.pool = doubled(self.pool, check)
