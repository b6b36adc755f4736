"""How an index lies in one array of int64: a head of `HEAD` numbers, then its sections, each from a whole word on.

Sections of int32 have two numbers to a word; where they begin is told in words all the same.
"""

import numpy as np
from numba import njit

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers

HEAD = 32

MAGIC, VERSION, SIZE, CHECK, FINGERPRINT = range(5)
"""Of the head: what this is, its version, how many words it has, a check sum of the head, and what map it is of."""

CORNERS, MOST_SEEN = 8, 9
"""How many corners there are, and how many of them a cell sees at most."""

TERRAIN, PLACES, LANDMARKS, LABELS, EDGES, WAYS, HUBS, LENGTHS, LINKS, STEPS, RANKS, END = range(10, 22)
"""Where the sections begin: the lines of the map; row and column of each corner, with the margin (int32 pairs); how far
each is from `LANDMARK_COUNT` of them (int32); where the label of each begins (n + 1), where its edges (n + 1), and
where the corners of each edge (m + 1); of all entries of labels the hubs, the lengths and the links (int32 each); the
corners of all edges (int32); how important each corner is, and how many were contracted (int32, n + 1)."""

LANDMARK_COUNT = 8


@njit(cache=True, nogil=True, error_model="numpy")
def words_of(index: Words, section: int) -> Words:
    """Return a section of int64."""
    return index[index[section] : index[section + 1]]


@njit(cache=True, nogil=True, error_model="numpy")
def integers_of(index: Words, section: int) -> Integers:
    """Return a section of int32; it may have one number more at its end than were put in."""
    return index.view(np.int32)[2 * index[section] : 2 * index[section + 1]]
