"""Kernel: a queue of cells by whole keys that never fall below the last one taken, as in A*.

A ring of buckets (Dial, 1969), each a linked list in one pool, with a tree of marks over them: a bit for each bucket
that holds anything, a bit for each such word, and so on. So a queue whose keys lie far apart costs no more than one
whose keys are dense: three words are looked at. Within a bucket the last one in is the first one out.

``heads`` has the first entry of each bucket, 0 if none; ``pool`` the cell and the next entry of each entry. All arrays
are handed over one by one: to take them out of a tuple costs as much as the work.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.kernels.bits import trailing_zeros
from ppaas.planners.kernels.jit_decorators import bare, inlined

Links = NDArray[np.int32]
Marks = NDArray[np.uint64]
Ints = NDArray[np.int64]

SLOT_BITS = 18
SLOTS = 1 << SLOT_BITS
_WORDS = SLOTS >> 6
_TOP = _WORDS + (_WORDS >> 6)
MARKS = _TOP + 1
"""Words in the tree: one bit a bucket, one a word of those, one a word of these."""

RING_STATE = 5
BUCKET, SHIFT, SIZE, USED, FREE = range(RING_STATE)
"""Of the state: number of the lowest bucket, width of a bucket as a power of two, entries in the queue, entries ever
used, the first that is free again (0 if none)."""

_ALL = np.uint64(0xFFFFFFFFFFFFFFFF)


@inlined
def push(heads: Links, marks: Marks, pool: Links, state: Ints, cell: int, key: int) -> None:
    """Put a cell in; the pool must have room, and the key be less than ``SLOTS`` buckets above the lowest."""
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
    """Return the first slot with anything in it, from one on and around; there must be one."""
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
    """Take a cell out of the lowest bucket; −1 if the queue is empty."""
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
    """Throw out what is in the queue, whose keys will be ``key`` or more."""
    slot = np.int64(0)
    while marks[_TOP] != 0:
        slot = _next_slot(marks, slot)
        heads[slot] = 0
        _unmark(marks, slot)
    state[SIZE] = state[USED] = state[FREE] = 0
    state[BUCKET] = key >> state[SHIFT]
