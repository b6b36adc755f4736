"""Kernel: monotone bucket queue of cells with integer keys, which never fall below the last key popped, as in A*.

It is a ring of buckets (Dial, 1969), each a linked list in one pool. A tree of bit sets over the buckets marks those
that are not empty: one bit per bucket, one bit per non-zero word of these, and so on. Finding the next bucket reads at
most a few words, also if keys are sparse. Within a bucket the order is last in, first out.

Arrays of the queue:

- ``heads``: (SLOTS,) int32, first entry of each bucket; 0 if it is empty.
- ``marks``: (MARKS,) uint64, the tree of bit sets.
- ``pool``: (capacity + 1, 2) int32, cell and next entry of each entry; entry 0 is unused.
- ``state``: int64, see below.

They are passed one by one, since unpacking a tuple takes as long as the operations.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare, inlined
from ppaas.planners.kernels.bits import trailing_zeros

Links = NDArray[np.int32]
Marks = NDArray[np.uint64]
Ints = NDArray[np.int64]

SLOT_BITS = 18
SLOTS = 1 << SLOT_BITS
_WORDS = SLOTS >> 6
_TOP = _WORDS + (_WORDS >> 6)
MARKS = _TOP + 1
"""Words in the tree: one bit per bucket, one per word of those, and one per word of these."""

RING_STATE = 5
BUCKET, SHIFT, SIZE, USED, FREE = range(RING_STATE)
"""Elements of the state: number of the lowest bucket, log₂ of the width of a bucket, entries in the queue, entries of
the pool ever used, first entry of the free list (0 if empty)."""

_ALL = np.uint64(0xFFFFFFFFFFFFFFFF)


@inlined
def push(heads: Links, marks: Marks, pool: Links, state: Ints, cell: int, key: int) -> None:
    """Insert a cell; the pool must not be full, and the key must be less than ``SLOTS`` buckets above the lowest."""
    entry = state[FREE]
    if entry:
        state[FREE] = pool[entry, 1]
    else:
        entry = state[USED] + np.int64(1)
        state[USED] = entry
    state[SIZE] += 1
    slot = (key >> state[SHIFT]) & (SLOTS - 1)
    head = heads[slot]
    pool[entry, 0] = cell
    pool[entry, 1] = head
    heads[slot] = entry
    if head == 0:
        marks[slot >> 6] |= np.uint64(1) << np.uint64(slot & 63)
        marks[_WORDS + (slot >> 12)] |= np.uint64(1) << np.uint64((slot >> 6) & 63)
        marks[_TOP] |= np.uint64(1) << np.uint64(slot >> 12)


@bare
def _next_slot(marks: Marks, slot: int) -> int:
    """Return the first non-empty slot from ``slot`` on, wrapping around; there must be one."""
    word = marks[slot >> 6] & (_ALL << np.uint64(slot & 63))
    if word != 0:
        return int((slot & ~63) + trailing_zeros(word))
    place = (slot >> 6) + 1
    if place & 63:
        word = marks[_WORDS + (place >> 6)] & (_ALL << np.uint64(place & 63))
        if word != 0:
            place = (place & ~63) + trailing_zeros(word)
            return int((place << 6) + trailing_zeros(marks[place]))
        place = (place | 63) + 1
    above = (place >> 6) & 63
    word = marks[_TOP] & (_ALL << np.uint64(above))
    if word == 0:
        word = marks[_TOP]
    above = trailing_zeros(word)
    place = (above << 6) + trailing_zeros(marks[_WORDS + above])
    return int((place << 6) + trailing_zeros(marks[place]))


@bare
def _unmark(marks: Marks, slot: int) -> None:
    marks[slot >> 6] ^= np.uint64(1) << np.uint64(slot & 63)
    if marks[slot >> 6] == 0:
        marks[_WORDS + (slot >> 12)] ^= np.uint64(1) << np.uint64((slot >> 6) & 63)
        if marks[_WORDS + (slot >> 12)] == 0:
            marks[_TOP] ^= np.uint64(1) << np.uint64(slot >> 12)


@inlined
def pop(heads: Links, marks: Marks, pool: Links, state: Ints) -> int:
    """Remove and return a cell of the lowest bucket; −1 if the queue is empty."""
    if state[SIZE] == 0:
        return -1
    slot = state[BUCKET] & (SLOTS - 1)
    if heads[slot] == 0:
        slot = _next_slot(marks, slot)
        state[BUCKET] += (slot - state[BUCKET]) & (SLOTS - 1)
    entry = heads[slot]
    heads[slot] = pool[entry, 1]
    if heads[slot] == 0:
        _unmark(marks, slot)
    pool[entry, 1] = state[FREE]
    state[FREE] = entry
    state[SIZE] -= 1
    return int(pool[entry, 0])


@bare
def empty(heads: Links, marks: Marks, state: Ints, key: int) -> None:
    """Clear the queue; its next keys will be ``key`` or more."""
    slot = np.int64(0)
    while marks[_TOP] != 0:
        slot = _next_slot(marks, slot)
        heads[slot] = 0
        _unmark(marks, slot)
    state[SIZE] = state[USED] = state[FREE] = 0
    state[BUCKET] = key >> state[SHIFT]
