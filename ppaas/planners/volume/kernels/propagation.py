"""Kernel: grow a field of costs in space, outward or towards a target, with a bucket queue.

Outward it is Dial's algorithm (1969) with wide buckets, as in `ppaas.planners.field.kernels.propagation`: all values in
the lowest bucket are final, and each voxel is worked off once. Towards a target it is A* (Hart, Nilsson, Raphael, 1968)
with the same buckets, by value plus the least that the way left can cost. There a voxel may be worked off again, if its
value falls while its own bucket is the lowest; when a bucket is empty, all values in it are final.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.volume.kernels.layout import (
    BLOCKED,
    BUCKET_SHIFT,
    CHUNK,
    DOWN,
    KINDS,
    MOST_CHUNKS,
    MOST_VALUE,
    NEEDS,
    RIGHT,
    RING,
    UNREACHED,
    UP,
)

Ints = NDArray[np.int64]
Links = NDArray[np.int32]
Pool = NDArray[np.uint32]

TOO_LONG = 4
"""The next values may not fit the field."""

STATE_SIZE = 6
BUCKET, FREE, SPARE, COUNT, EMPTY, TOUCHED = range(STATE_SIZE)
"""Of the queue's state: number of the lowest bucket, first free chunk, free chunks, voxels worked off, empty buckets
passed in a row, and what ``_touch`` gave last."""


@njit(cache=True, nogil=True, error_model="numpy")
def least_left(layers: int, rows: int, columns: int, least: Ints) -> int:
    """Return what the shortest way over so many layers, rows and columns costs, all of it free.

    Parameters
    ----------
    least : (3,) int64 array
        Weights of free voxels, on moves along one, two and three axes; zeros to search in all directions alike.
    """
    layers, rows, columns = abs(layers), abs(rows), abs(columns)
    most, fewest = max(layers, rows, columns), min(layers, rows, columns)
    middle = layers + rows + columns - most - fewest
    return int(fewest * least[2] + (middle - fewest) * least[1] + (most - middle) * least[0])


@njit(cache=True, nogil=True, error_model="numpy")
def _touch(field: NDArray[np.uint32], costs: NDArray[np.uint8], stride: int, plane: int, voxels: Pool) -> int:
    """Read what lies around some voxels, so that it is at hand when they are worked off.

    The nine rows around a voxel are as many lines of the cache, and here none waits for another; without this a large
    field takes almost twice as long. What is returned must be kept, or the compiler leaves all of it out.
    """
    seen = 0
    for voxel in voxels:
        for layer in range(-1, 2):
            for row in range(-1, 2):
                beside = np.int64(voxel) + layer * plane + row * stride
                seen ^= int(field[beside]) ^ int(costs[beside])
    return seen


@njit(cache=True, nogil=True, error_model="numpy")
def propagate(
    field: NDArray[np.uint32], costs: NDArray[np.uint8], stride: int, plane: int, weights: Ints, least: Ints,
    pool: Pool, links: Links, heads: Links, fills: Links, state: Ints, target: int, budget: int,
) -> int:  # fmt: skip
    """Work off about ``budget`` voxels and tell why it stopped.

    Parameters
    ----------
    field : (n,) uint32 array
        Values, as in `ppaas.planners.volume.kernels.layout`.
    costs : (n,) uint8 array
        Costs of the voxels.
    stride, plane : int
        Elements in a row and in a layer.
    weights : (3, 256) int64 array
        What entering a voxel of that cost weighs, on a move along one, two and three axes.
    least : (3,) int64 array
        As in ``least_left``: the weights of free voxels to aim at the target, zeros not to.
    pool : (chunks, CHUNK) uint32 array
        Voxels in the queue.
    links : (chunks,) int32 array
        The chunk after each, in its bucket or among the free ones; −1 ends.
    heads, fills : (RING,) int32 array
        First chunk of each bucket, and voxels in it; a bucket without chunks has −1 and CHUNK.
    state : (STATE_SIZE,) int64 array
    target : int
        Voxel whose value is wanted; −1 to go on until all are reached.
    budget : int
        Voxels to work off before it pauses, give or take a chunk.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED, POOL_EMPTY or TOO_LONG.
    """
    offsets = np.empty(26, np.int64)
    for move in range(26):
        offsets[move] = UP[move] * plane + DOWN[move] * stride + RIGHT[move]
    aimed = least[0] > 0
    layer, row, column = 0, 0, 0
    end = state[COUNT] + budget
    while True:
        bucket = state[BUCKET]
        low = bucket << BUCKET_SHIFT
        if target >= 0 and field[target] != UNREACHED and np.int64(field[target]) < low:
            return SETTLED
        if low + (RING << BUCKET_SHIFT) > MOST_VALUE:
            return TOO_LONG
        slot = bucket & (RING - 1)
        while heads[slot] >= 0:
            if state[COUNT] >= end:
                return PAUSED
            if state[SPARE] < MOST_CHUNKS:
                return POOL_EMPTY
            chunk, fill = heads[slot], fills[slot]
            heads[slot], fills[slot] = links[chunk], CHUNK
            state[TOUCHED] = _touch(field, costs, stride, plane, pool[chunk, :fill])
            for entry in range(fill):
                voxel = int(pool[chunk, entry])
                value = int(field[voxel])
                left = 0
                if aimed:
                    layer = target // plane - voxel // plane
                    row = target % plane // stride - voxel % plane // stride
                    column = target % stride - voxel % stride
                    left = least_left(layer, row, column, least)
                if value + left < low:
                    continue
                state[COUNT] += 1
                open_moves = 0
                for move in range(26):
                    if open_moves & NEEDS[move] != NEEDS[move]:
                        continue
                    neighbour = voxel + offsets[move]
                    old = int(field[neighbour])
                    if old == BLOCKED:
                        continue
                    open_moves |= 1 << move
                    kind = KINDS[move]
                    if old <= value + weights[kind, 0]:
                        continue
                    new = value + weights[kind, costs[neighbour]]
                    if new >= old:
                        continue
                    field[neighbour] = new
                    if aimed:
                        left = least_left(layer - UP[move], row - DOWN[move], column - RIGHT[move], least)
                    later = (new + left) >> BUCKET_SHIFT
                    if later == (old + left) >> BUCKET_SHIFT and later != bucket:
                        continue  # it is in that bucket already, and not yet worked off
                    later &= RING - 1
                    if fills[later] == CHUNK:
                        fresh = state[FREE]
                        state[FREE] = links[fresh]
                        state[SPARE] -= 1
                        links[fresh], heads[later], fills[later] = heads[later], fresh, 0
                    pool[heads[later], fills[later]] = neighbour
                    fills[later] += 1
            state[EMPTY] = -1
            links[chunk] = state[FREE]
            state[FREE] = chunk
            state[SPARE] += 1
        state[EMPTY] += 1
        state[BUCKET] += 1
        if state[EMPTY] >= RING:
            return EXHAUSTED


def warm() -> None:
    """Compile and call the kernel once."""
    field = np.zeros(27, np.uint32)
    field[13] = UNREACHED
    weights = np.full((3, 256), 1 << BUCKET_SHIFT, np.int64)
    chunks = 1 + MOST_CHUNKS
    propagate(
        field, np.zeros(27, np.uint8), 3, 9, weights, np.zeros(3, np.int64), np.empty((chunks, CHUNK), np.uint32),
        np.arange(1, chunks + 1, dtype=np.int32), np.full(RING, -1, np.int32), np.full(RING, CHUNK, np.int32),
        np.array([0, 0, chunks, 0, 0, 0]), -1, 1,
    )  # fmt: skip
