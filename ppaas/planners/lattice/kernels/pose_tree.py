"""Kernel: nodes of a search over poses, with a hash table by cell and heading bin."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import compiled

Floats = NDArray[np.float64]
Links = NDArray[np.int32]
Keys = NDArray[np.int64]

PARENT, MOTION, BIN, CLOSED, LEAVING = range(5)
"""Columns of ``links``: parent node, motion from it, heading bin, and two flags: whether the node is closed, and
whether the robot is still leaving the blocked cells that it started in."""


class PoseTree(NamedTuple):
    """Search tree and queue, with a capacity of n nodes.

    Attributes
    ----------
    poses : (n, 3) float64 array
        x, y, theta of each node [cells, rad].
    costs : (n,) float64 array
        Cost from the start.
    links : (n, 5) int32 array
        PARENT, MOTION, BIN, CLOSED, LEAVING.
    keys : (n,) int64 array
        Index of the cell · number of bins + bin.
    table : (m,) int32 array
        Open-addressing hash table of the nodes by key; −1 is free, m is a power of two.
    heap : (n + 2, 2) float64 array
    entries : (n + 2,) int32 array
    places : (n,) int32 array
        The queue, as in `ppaas.planners.kernels.indexed_heap`.
    """

    poses: Floats
    costs: Floats
    links: Links
    keys: Keys
    table: Links
    heap: Floats
    entries: Links
    places: Links


@compiled
def find(keys: Keys, table: Links, key: int) -> int:
    """Return the slot of a key in the hash table, or the free slot to insert it (linear probing)."""
    mask = len(table) - 1
    at = (((key * 0x2545F4914F6CDD1D) >> 20) ^ key) & mask
    while table[at] >= 0 and keys[table[at]] != key:
        at = (at + 1) & mask
    return at


@compiled
def fill_table(keys: Keys, table: Links, first: int, last: int) -> None:
    """Insert nodes ``first`` to ``last``, ``last`` excluded, which are not in the table."""
    for node in range(first, last):
        table[find(keys, table, keys[node])] = node


def warm() -> None:
    """Compile and call each kernel once."""
    keys, table = np.zeros(1, np.int64), np.full(4, -1, np.int32)
    fill_table(keys, table, 0, 1)
