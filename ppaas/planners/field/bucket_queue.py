"""Arrays of the bucket queue of the propagation kernel, and their growth."""

from collections.abc import Callable

import numpy as np

from ppaas.planners.array_growth import doubled
from ppaas.planners.field.kernels.layout import CHUNK, MAX_CHUNKS, RING
from ppaas.planners.field.kernels.propagation import FREE, SPARE, STATE_SIZE


class BucketQueue:
    """Ring of buckets, each a linked list of chunks from one pool.

    Parameters
    ----------
    cells : int
        Number of cells to insert before the first call of the kernel.
    """

    def __init__(self, cells: int) -> None:
        chunks = MAX_CHUNKS + 32 + cells // CHUNK + 1
        self.pool = np.empty((chunks, CHUNK), np.uint32)
        self.links = np.arange(1, chunks + 1, dtype=np.int32)
        self.links[-1] = -1
        self.heads = np.full(RING, -1, np.int32)
        self.fills = np.full(RING, CHUNK, np.int32)
        self.state = np.zeros(STATE_SIZE, np.int64)
        self.state[SPARE] = chunks

    def grow(self, check: Callable[[], None]) -> None:
        """Double the pool; the queued cells remain in it."""
        chunks = len(self.pool)
        self.pool = doubled(self.pool, check)
        added = np.arange(chunks + 1, 2 * chunks + 1, dtype=np.int32)
        added[-1] = self.state[FREE]
        self.links = np.concatenate((self.links, added))
        self.state[FREE] = chunks
        self.state[SPARE] += chunks
