"""Arrays of the bucket queue of the propagation kernel in space, and their growth."""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.volume.kernels.layout import CHUNK, MAX_CHUNKS, RING
from ppaas.planners.volume.kernels.propagation import BUCKET, COUNT, FREE, SPARE, STATE_SIZE


class VoxelBucketQueue:
    """Ring of buckets, each a linked list of chunks from one pool.

    Parameters
    ----------
    voxels : (n,) uint32 array
        Initial contents.
    bucket : int
        Number of the bucket that holds all of them, the lowest one.
    """

    def __init__(self, voxels: NDArray[np.uint32], bucket: int) -> None:
        taken = -(-len(voxels) // CHUNK)
        chunks = taken + 2 * MAX_CHUNKS
        self.pool = np.empty((chunks, CHUNK), np.uint32)
        self.pool.ravel()[: len(voxels)] = voxels
        self.links = np.arange(1, chunks + 1, dtype=np.int32)
        self.links[:taken] = np.arange(-1, taken - 1)
        self.links[-1] = -1
        self.heads = np.full(RING, -1, np.int32)
        self.fills = np.full(RING, CHUNK, np.int32)
        slot = bucket & (RING - 1)
        self.heads[slot] = taken - 1
        self.fills[slot] = len(voxels) - (taken - 1) * CHUNK
        self.state = np.zeros(STATE_SIZE, np.int64)
        self.state[BUCKET], self.state[FREE], self.state[SPARE] = bucket, taken, chunks - taken

    @property
    def expanded(self) -> int:
        """Number of expansions; a voxel expanded twice counts twice."""
        return int(self.state[COUNT])

    def grow(self) -> None:
        """Enlarge the pool by half; the queued voxels remain in it."""
        chunks = len(self.pool)
        more = chunks // 2
        self.pool = np.concatenate((self.pool, np.empty((more, CHUNK), np.uint32)))
        added = np.arange(chunks + 1, chunks + more + 1, dtype=np.int32)
        added[-1] = self.state[FREE]
        self.links = np.concatenate((self.links, added))
        self.state[FREE] = chunks
        self.state[SPARE] += more
