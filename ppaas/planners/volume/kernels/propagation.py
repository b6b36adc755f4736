"""Kernel: grow a cost field in space, outward or towards a target, with a bucket queue.

Outward it is Dial's algorithm (1969) with wide buckets, as in `ppaas.planners.field.kernels.propagation`: all values in
the lowest bucket are final, and each voxel is expanded once. Towards a target it is A* (Hart, Nilsson and Raphael,
1968) with the same buckets, keyed by the value plus a lower bound of the remaining cost. A voxel is then expanded again
if its value falls while its bucket is the lowest one; once a bucket is empty, all values in it are final.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED, POOL_EMPTY, SETTLED
from ppaas.planners.volume.kernels.layout import (
    BLOCKED,
    BUCKET_SHIFT,
    CHUNK,
    DOWN,
    KINDS,
    MAX_CHUNKS,
    MAX_VALUE,
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
"""The next values may exceed `MAX_VALUE`."""

STATE_SIZE = 6
BUCKET, FREE, SPARE, COUNT, EMPTY, TOUCHED = range(STATE_SIZE)
"""Elements of the queue's state: number of the lowest bucket, first free chunk, number of free chunks, expansions,
consecutive empty buckets, and the last result of ``_touch``."""


@compiled
def least_left(layers: int, rows: int, columns: int, least: Ints) -> int:
    """Return the cost of the shortest path over a distance in an empty map: the heuristic of A*.

    Parameters
    ----------
    layers, rows, columns : int
        The distance along each axis, of either sign.
    least : (3,) int64 array
        Weights of moves into free voxels along one, two and three axes; zeros to search without a heuristic.
    """
    layers, rows, columns = abs(layers), abs(rows), abs(columns)
    most, fewest = max(layers, rows, columns), min(layers, rows, columns)
    middle = layers + rows + columns - most - fewest
    return int(fewest * least[2] + (middle - fewest) * least[1] + (most - middle) * least[0])


@compiled
def _touch(field: NDArray[np.uint32], costs: NDArray[np.uint8], stride: int, plane: int, voxels: Pool) -> int:
    """Read the neighbourhoods of voxels into the cache before they are expanded.

    The nine rows around a voxel are in nine cache lines, and the loads here do not depend on each other. Without this a
    large field takes almost twice as long. The caller must store the result, or the compiler removes the loads.
    """
    seen = 0
    for voxel in voxels:
        for layer in range(-1, 2):
            for row in range(-1, 2):
                beside = np.int64(voxel) + layer * plane + row * stride
                seen ^= int(field[beside]) ^ int(costs[beside])
    return seen


@compiled
def propagate(
    field: NDArray[np.uint32], costs: NDArray[np.uint8], stride: int, plane: int, weights: Ints, least: Ints,
    pool: Pool, links: Links, heads: Links, fills: Links, state: Ints, target: int, budget: int,
) -> int:  # fmt: skip
    """Expand about ``budget`` voxels and return why the kernel stopped.

    Parameters
    ----------
    field : (n,) uint32 array
        Values, as in `ppaas.planners.volume.kernels.layout`. In and out.
    costs : (n,) uint8 array
        Costs of the voxels.
    stride, plane : int
        Number of elements in a row and in a layer.
    weights : (3, 256) int64 array
        Weight of entering a voxel of each cost, on a move along one, two and three axes.
    least : (3,) int64 array
        As in ``least_left``: weights of free voxels for A* towards the target, zeros for Dijkstra's order.
    pool : (chunks, CHUNK) uint32 array
        Queued voxels. In and out, as the other arrays of the queue.
    links : (chunks,) int32 array
        Next chunk of each chunk, in its bucket or in the free list; −1 at the end.
    heads, fills : (RING,) int32 array
        First chunk of each bucket, and the number of voxels in it; −1 and CHUNK for a bucket without chunks.
    state : (STATE_SIZE,) int64 array
    target : int
        Voxel whose value is wanted; −1 to reach all.
    budget : int
        Number of voxels to expand in this call, up to a chunk more.

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
        if low + (RING << BUCKET_SHIFT) > MAX_VALUE:
            return TOO_LONG
        # Expand the lowest bucket, chunk by chunk; relaxations may add chunks to it again.
        slot = bucket & (RING - 1)
        while heads[slot] >= 0:
            if state[COUNT] >= end:
                return PAUSED
            if state[SPARE] < MAX_CHUNKS:
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
                if value + left < low:  # a stale entry: the voxel was expanded with a lower value
                    continue
                state[COUNT] += 1
                # Relax the moves to its free neighbours that cut no corner.
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
                        continue  # already queued in that bucket, and not yet expanded
                    later &= RING - 1
                    # Append it to its bucket; take a chunk from the free list if the first one is full.
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
        # Advance to the next bucket; after a whole ring of empty ones the queue is empty.
        state[EMPTY] += 1
        state[BUCKET] += 1
        if state[EMPTY] >= RING:
            return EXHAUSTED


def warm() -> None:
    """Compile and call the kernel once."""
    field = np.zeros(27, np.uint32)
    field[13] = UNREACHED
    weights = np.full((3, 256), 1 << BUCKET_SHIFT, np.int64)
    chunks = 1 + MAX_CHUNKS
    propagate(
        field, np.zeros(27, np.uint8), 3, 9, weights, np.zeros(3, np.int64), np.empty((chunks, CHUNK), np.uint32),
        np.arange(1, chunks + 1, dtype=np.int32), np.full(RING, -1, np.int32), np.full(RING, CHUNK, np.int32),
        np.array([0, 0, chunks, 0, 0, 0]), -1, 1,
    )  # fmt: skip
