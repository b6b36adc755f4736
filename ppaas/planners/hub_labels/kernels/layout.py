"""How an index lies in one array of int64: a head of `HEAD` numbers, then its sections, each from a whole word on.

All sections but the first are int32, two to a word. Of each corner there are `CORNER_SIZE` numbers: its row and its
column, with the margin; where its label begins among the labels; and where its ways begin among the ways. The label of
a corner is the hubs of all its entries, then all their lengths, then all their links. A way is how many corners it has,
how many moves, and the corners, up to its end.

An entry of a label *links* to the entry of the same hub in the label one way nearer to the hub: a link is where that
way lies after the first way of the corner, shifted by `LINK_SHIFT`, and the place of the entry in that label; −1 in the
label of the hub itself.
"""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.bare import inlined
from ppaas.planners.kernels.simd import LANES

HEAD = 32

MAGIC, VERSION, SIZE, CHECK, FINGERPRINT = range(5)
"""Of the head: what this is, its version, how many words it has, a check sum of the head, and what map it is of."""

CORNERS, MOST_SEEN, LANDMARK_COUNT = 8, 9, 10
"""How many corners there are, how many of them a cell sees at most, and how many are landmarks: none, or `MARKS`."""

TERRAIN, TABLE, LANDMARKS, LABELS, WAYS, RANKS, END = range(11, 18)
"""Where the sections begin: the lines of the map (int64); the numbers of the corners, and those of their end; how far
each is from the landmarks; the labels; the ways; how important each corner is, and how many were contracted."""

ROW, COLUMN, LABEL, WAY, CORNER_SIZE = range(5)
WAY_CORNERS, WAY_MOVES, WAY_HEAD = range(3)
MARKS = LANES

LINK_SHIFT = 16
PLACE_BITS = (1 << LINK_SHIFT) - 1
MOST_WAYS = (1 << (31 - LINK_SHIFT)) - 1
"""Numbers after the first way of a corner, and entries of its label, that links can tell: the latter `PLACE_BITS`."""


@inlined
def words_of(index: Words, section: int) -> Words:
    """Return a section of int64."""
    return index[index[section] : index[section + 1]]


@inlined
def integers_of(index: Words, section: int) -> Integers:
    """Return a section of int32; it may have one number more at its end than were put in."""
    return index.view(np.int32)[2 * index[section] : 2 * index[section + 1]]
