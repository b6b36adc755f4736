"""A histogram over poses, in a hash table: amcl's ``pf_kdtree.c`` keeps the same bins in a tree."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

BIN_EDGE, BIN_TURN = 0.5, math.radians(10.0)
"""Bins of the histogram [m, rad], as in amcl."""

NONE = np.int64(-(1 << 63))
"""What no bin is numbered."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


@njit(cache=True, nogil=True, error_model="numpy")
def bin_of(x: float, y: float, theta: float) -> int:
    """Return the bin of a pose as one integer."""
    column, row = np.int64(math.floor(x / BIN_EDGE)), np.int64(math.floor(y / BIN_EDGE))
    turn = np.int64(math.floor(theta / BIN_TURN))
    return int((column << 40) ^ ((row & 0xFFFFF) << 16) ^ (turn & 0xFFFF))


@njit(cache=True, nogil=True, error_model="numpy")
def empty_table(count: int) -> NDArray[np.int64]:
    """Return a hash table without bins that has room for so many."""
    size = 16
    while size < 2 * count:
        size *= 2
    return np.full(size, NONE)


@njit(cache=True, nogil=True, error_model="numpy")
def slot_of(table: NDArray[np.int64], key: int) -> int:
    """Return where a bin is in the table, or where it belongs: the first free slot from its hash on."""
    mask = table.size - 1
    slot = int((np.uint64(key) * _GOLDEN) >> np.uint64(32)) & mask
    while table[slot] != NONE and table[slot] != key:
        slot = (slot + 1) & mask
    return slot
