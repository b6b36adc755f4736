"""Kernel: grow a cost field from its goals outward, with a bucket queue.

Dial's algorithm (1969) with buckets as wide as the least weight allows (Denardo and Fox, 1979): no move ends in the
bucket where it began, so all values in the lowest bucket are final, and each cell is expanded once, in any order within
its bucket. A bucket is a linked list of chunks from one pool. If the value of a queued cell falls, the cell is queued
again, and its stale entry is skipped later (lazy deletion).
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled
from ppaas.planners.field.kernels.layout import (
    AHEAD,
    AT_GOAL,
    BUCKET_SHIFT,
    CHUNK,
    MAX_CHUNKS,
    RING,
    UNREACHED,
    UNREACHED_WIDE,
)
from ppaas.planners.kernels.moves import EXHAUSTED, NEEDS, PAUSED, POOL_EMPTY, SETTLED

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Pool = NDArray[np.uint32]
Links = NDArray[np.int32]
Field = NDArray[np.uint32] | NDArray[np.int64]

TOO_NARROW = 4
"""The next values may exceed the field's type: convert it to int64 and call again."""

STATE_SIZE = 5
BUCKET, FREE, SPARE, COUNT, EMPTY = range(STATE_SIZE)
"""Elements of the queue's state: number of the lowest bucket, first free chunk, number of free chunks, settled cells,
consecutive empty buckets."""


@compiled
def seed(field: Field, cells: Ints, pool: Pool, links: Links, heads: Links, fills: Links, state: Ints) -> None:
    """Insert the goals into an empty queue, whose pool must be large enough; duplicates are inserted once."""
    for cell in cells:
        if np.int64(field[cell]) == AT_GOAL:
            continue
        field[cell] = AT_GOAL
        if fills[0] == CHUNK:
            fresh = state[FREE]
            state[FREE] = links[fresh]
            state[SPARE] -= 1
            links[fresh] = heads[0]
            heads[0] = fresh
            fills[0] = 0
        pool[heads[0], fills[0]] = cell
        fills[0] += 1


@compiled
def _follow(
    field: Field, costs: NDArray[np.uint8], stride: int, weights: Ints,
    cell: Int, came: Int, value: Int, old: Int, most: Int,
) -> tuple[Int, Int, Int, Int]:  # fmt: skip
    """Follow a corridor one cell wide, where each cell has a single successor and no queue is needed.

    Values of passed cells may still be improved later, as those of queued cells; the corridor is then followed again.
    Diagonal moves out of a corridor need not be tried: they cost no less than moves from the cell before.

    Parameters
    ----------
    field, costs, stride, weights
        As in `propagate`.
    cell, came : int
        First cell, and the offset of the cardinal move by which it was reached.
    value, old : int
        New and previous value of the cell.
    most : int
        Stop at values of at least this.

    Returns
    -------
    cell, value, old : int
        The first cell with several successors, with its new and previous value; the cell is −1 if the corridor is a
        dead end, or nothing is improved in it.
    passed : int
        Number of cells passed.
    """
    passed: Int = 0
    aside: Int = stride if came in (-1, 1) else 1
    while value < most:
        ahead = np.int64(field[cell + came] > 0)
        one, other = np.int64(field[cell + aside] > 0), np.int64(field[cell - aside] > 0)
        if ahead + one + other != 1:
            return (cell if ahead + one + other else -1), value, old, passed
        # Arithmetic instead of branches, which would be mispredicted at every turn of the corridor.
        came, aside = ahead * came + (one - other) * aside, ahead * aside + (one + other) * came
        cell += came
        passed += 1
        value += weights[0, costs[cell]]
        old = np.int64(field[cell])
        if value >= old:
            return -1, value, old, passed
        field[cell] = value
    return cell, value, old, passed


@compiled
def propagate(
    field: Field, costs: NDArray[np.uint8], stride: int, weights: Ints,
    pool: Pool, links: Links, heads: Links, fills: Links, state: Ints, target: int, limit: int, budget: int,
) -> int:  # fmt: skip
    """Expand about ``budget`` cells and return why the kernel stopped.

    Parameters
    ----------
    field : (n,) uint32 or int64 array
        Values, as in `ppaas.planners.field.kernels.layout`. In and out.
    costs : (n,) uint8 array
        Costs of the cells, padded.
    stride : int
        Number of elements in a row.
    weights : (2, 256) int64 array
        Weight of entering a cell of each cost, on a cardinal and on a diagonal move.
    pool : (chunks, CHUNK) uint32 array
        Queued cells. In and out, as the other arrays of the queue.
    links : (chunks,) int32 array
        Next chunk of each chunk, in its bucket or in the free list; −1 at the end.
    heads, fills : (RING,) int32 array
        First chunk of each bucket, and the number of cells in it; −1 and CHUNK for a bucket without chunks.
    state : (STATE_SIZE,) int64 array
    target : int
        Cell whose value is wanted; −1 to reach all.
    limit : int
        Largest value that the field can hold.
    budget : int
        Number of cells to expand in this call, up to a chunk more.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED, POOL_EMPTY or TOO_NARROW.
    """
    offsets = (-1, 1, -stride, stride, -stride - 1, -stride + 1, stride - 1, stride + 1)
    bucket = state[BUCKET]
    end = state[COUNT] + budget
    while True:
        low = bucket << BUCKET_SHIFT
        if target >= 0 and np.int64(field[target]) < low + (1 << BUCKET_SHIFT):
            return SETTLED
        if low + ((1 << BUCKET_SHIFT) * RING) > limit:
            return TOO_NARROW
        # Expand the lowest bucket, chunk by chunk.
        slot = bucket & (RING - 1)
        while heads[slot] >= 0:
            if state[COUNT] >= end:
                return PAUSED
            if state[SPARE] < MAX_CHUNKS:
                return POOL_EMPTY
            chunk = heads[slot]
            fill = fills[slot]
            heads[slot] = links[chunk]
            fills[slot] = CHUNK
            settled: Int = 0
            for entry in range(fill):
                cell = np.int64(pool[chunk, entry])
                value = np.int64(field[cell])
                if value < low:  # a stale entry: the cell was settled from a lower bucket
                    continue
                settled += 1
                # Relax the moves to its free neighbours; diagonal ones need both cells beside them free.
                open_sides = 0
                for move in range(8):
                    if open_sides & NEEDS[move] != NEEDS[move]:
                        continue
                    neighbour: Int = cell + offsets[move]
                    old: Int = np.int64(field[neighbour])
                    if old > 0 and move < 4:
                        open_sides |= 1 << move
                    if old <= value:
                        continue
                    new: Int = value + weights[move >> 2, costs[neighbour]]
                    if new >= old:
                        continue
                    field[neighbour] = new
                    if move < 4:
                        neighbour, new, old, passed = _follow(
                            field, costs, stride, weights, neighbour, offsets[move], new, old, low + AHEAD
                        )
                        settled += passed
                        if neighbour < 0:
                            continue
                    later = new >> BUCKET_SHIFT
                    if later == old >> BUCKET_SHIFT:
                        continue  # already queued in that bucket
                    # Append it to its bucket; take a chunk from the free list if the first one is full.
                    later &= RING - 1
                    if fills[later] == CHUNK:
                        fresh = state[FREE]
                        state[FREE] = links[fresh]
                        state[SPARE] -= 1
                        links[fresh] = heads[later]
                        heads[later] = fresh
                        fills[later] = 0
                    pool[heads[later], fills[later]] = neighbour
                    fills[later] += 1
            state[COUNT] += settled
            state[EMPTY] = -1
            # Return the chunk to the free list.
            links[chunk] = state[FREE]
            state[FREE] = chunk
            state[SPARE] += 1
        # Advance to the next bucket; after a whole ring of empty ones the queue is empty.
        state[EMPTY] += 1
        bucket += 1
        state[BUCKET] = bucket
        if state[EMPTY] >= RING:
            return EXHAUSTED


def warm() -> None:
    """Compile and call each kernel once, for 32-bit and 64-bit fields."""
    weights = np.full((2, 256), 1 << BUCKET_SHIFT, np.int64)
    chunks = 1 + MAX_CHUNKS
    narrow, wide = np.zeros(9, np.uint32), np.zeros(9, np.int64)
    narrow[4], wide[4] = UNREACHED, UNREACHED_WIDE
    for field in (narrow, wide):
        queue = (
            np.empty((chunks, CHUNK), np.uint32),
            np.arange(1, chunks + 1, dtype=np.int32),
            np.full(RING, -1, np.int32),
            np.full(RING, CHUNK, np.int32),
            np.array([0, 0, chunks, 0, 0]),
        )
        seed(field, np.array([4]), *queue)
        propagate(field, np.zeros(9, np.uint8), 3, weights, *queue, -1, 1 << 31, 9)
