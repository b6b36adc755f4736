"""The bucket queue of the propagation kernel: its arrays, and how they grow."""

from collections.abc import Callable

import numpy as np

from ppaas.planners.array_growth import doubled
from ppaas.planners.field.kernels.layout import CHUNK, MOST_CHUNKS, RING
from ppaas.planners.field.kernels.propagation import FREE, SPARE, STATE_SIZE


class BucketQueue:
    """A ring of buckets whose chunks come out of one pool.

    Parameters
    ----------
    cells : int
        How many cells it must hold at once to begin with.
    """

    def __init__(self, cells: int) -> None:
        chunks = MOST_CHUNKS + 32 + cells // CHUNK + 1
        self.pool = np.empty((chunks, CHUNK), np.uint32)
        self.links = np.arange(1, chunks + 1, dtype=np.int32)
        self.links[-1] = -1
        self.heads = np.full(RING, -1, np.int32)
        self.fills = np.full(RING, CHUNK, np.int32)
        self.state = np.zeros(STATE_SIZE, np.int64)
        self.state[SPARE] = chunks

    def grow(self, check: Callable[[], None]) -> None:
        """Double the pool; the cells in the queue stay in it."""
        chunks = len(self.pool)
        self.pool = doubled(self.pool, check)
        added = np.arange(chunks + 1, 2 * chunks + 1, dtype=np.int32)
        added[-1] = self.state[FREE]
        self.links = np.concatenate((self.links, added))
        self.state[FREE] = chunks
        self.state[SPARE] += chunks
