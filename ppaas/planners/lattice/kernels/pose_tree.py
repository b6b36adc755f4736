"""Kernel: the nodes of a search over poses, found by their cell and heading."""

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Links = NDArray[np.int32]
Keys = NDArray[np.int64]

PARENT, MOTION, BIN, CLOSED, LEAVING = range(5)
"""Of a node's links: the node before it, the motion from there, its bin of headings, and two marks."""


class Tree(NamedTuple):
    """The nodes reached, in arrays with room for more.

    ``spots`` (n, 3): x, y, theta; ``worths`` (n,): what it cost to get there; ``links`` (n, 5) int32;
    ``keys`` (n,) int64: cell and bin; ``table`` (m,) int32: nodes by hash of their key, −1 where none, m a power of
    two; ``heap`` (n + 2, 2), ``entries`` (n + 2,) int32 and ``places`` (n,) int32: as in
    `ppaas.planners.kernels.indexed_heap`.
    """

    spots: Floats
    worths: Floats
    links: Links
    keys: Keys
    table: Links
    heap: Floats
    entries: Links
    places: Links


@njit(cache=True, nogil=True, error_model="numpy")
def find(keys: Keys, table: Links, key: int) -> int:
    """Return the place of a key in the hash table, or the free one where it belongs."""
    mask = len(table) - 1
    at = (((key * 0x2545F4914F6CDD1D) >> 20) ^ key) & mask
    while table[at] >= 0 and keys[table[at]] != key:
        at = (at + 1) & mask
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def fill_table(keys: Keys, table: Links, first: int, last: int) -> None:
    """Put some nodes into a table that does not have them yet."""
    for node in range(first, last):
        table[find(keys, table, keys[node])] = node


def warm() -> None:
    """Compile and call each kernel once."""
    keys, table = np.zeros(1, np.int64), np.full(4, -1, np.int32)
    fill_table(keys, table, 0, 1)
