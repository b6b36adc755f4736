"""Kernels: histogram over poses in a hash table, with the bins of amcl's ``pf_kdtree.c``, which uses a tree."""

import math

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

BIN_EDGE, BIN_TURN = 0.5, math.radians(10.0)
"""Size of a bin [m, rad], as in amcl."""

NONE = np.int64(-(1 << 63))
"""Key of an empty slot; no bin has it."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
"""2⁶⁴ / golden ratio, the multiplier of Fibonacci hashing (Knuth, *The Art of Computer Programming*, vol. 3, 6.4)."""


@compiled
def bin_of(x: float, y: float, theta: float) -> int:
    """Return the key of the bin of a pose (x, y [m], theta [rad])."""
    column, row = np.int64(math.floor(x / BIN_EDGE)), np.int64(math.floor(y / BIN_EDGE))
    turn = np.int64(math.floor(theta / BIN_TURN))
    return int((column << 40) ^ ((row & 0xFFFFF) << 16) ^ (turn & 0xFFFF))


@compiled
def empty_table(count: int) -> NDArray[np.int64]:
    """Return an empty hash table with space for ``count`` bins at a load of at most one half."""
    size = 16
    while size < 2 * count:
        size *= 2
    return np.full(size, NONE)


@compiled
def slot_of(table: NDArray[np.int64], key: int) -> int:
    """Return the slot of a bin: the one that holds it, or the first empty one after its hash (linear probing)."""
    mask = table.size - 1
    slot = int((np.uint64(key) * _GOLDEN) >> np.uint64(32)) & mask
    while table[slot] != NONE and table[slot] != key:
        slot = (slot + 1) & mask
    return slot
