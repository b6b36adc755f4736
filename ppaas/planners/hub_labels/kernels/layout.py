"""How an index lies in one array of int64: a head of `HEAD` numbers, then its sections, each from a whole word on.

Corners are told by their ranks, 0 the most important. Of each there are `CORNER_SIZE` int32 numbers: its row and its
column, with the margin; where its label begins among the labels; and how many entries it has.

The most important corners are *labelled*; where all labels would take too much room, the rest is the *fringe*. Of a
corner of the fringe, the number of entries is −1 − how many edges lead from it to more important corners. In place of
its label are `FRINGE_HEAD` numbers: the rectangle that holds what is reached over local edges, and how many gates it
has. Then come the gates (see `HUB_BITS`), all their lengths, and the edges: all corners they lead to, then all their
lengths, negative but for local edges, then all their ways.

Labels are int32. The label of a corner is the hubs of all its entries, two to a number, then all their lengths, then
all their links. A link is two numbers: where the link of the same hub lies in the label one way nearer to the hub, −1
if the way leads to the hub itself; and where that way lies among the ways, −1 in the hub's own label.

Ways are uint16, each one or more runs: a *run* is a direction, above it how many moves it goes that way, and above
that whether it is the last one of its way. So whoever follows links looks at one place a way, and whoever writes cells
looks at the ways one number after the other.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import inlined, joined
from ppaas.planners.kernels.simd import LANES

Shorts = NDArray[np.uint16]

HEAD = 32

MAGIC, VERSION, SIZE, CHECK, FINGERPRINT = range(5)
"""Of the head: what this is, its version, how many words it has, a check sum of the head, and what map it is of."""

CORNERS, LABELLED, MOST_SEEN, LANDMARK_COUNT = range(8, 12)
"""How many corners there are, how many of them have labels, how many a cell sees at most, and how many are landmarks:
none, or `MARKS`."""

TERRAIN, TABLE, LANDMARKS, LABELS, WAYS, RANKS, END = range(12, 19)
"""Where the sections begin: the lines of the map (int64); the numbers of the corners; how far those with labels are
from the landmarks, `FAR` where no way leads; the labels; the ways; the rank of each corner, row by row, and how many
were contracted (int32)."""

ROW, COLUMN, LABEL, ENTRIES, CORNER_SIZE = range(5)
LINK_NEXT, LINK_WAY, LINK_SIZE = range(3)

FAR = np.int32(2**30)
"""Longer than any way."""

TOP, BOTTOM, LEFTMOST, RIGHTMOST, GATE_COUNT, FRINGE_HEAD = range(6)
"""Of a corner of the fringe: the rectangle of what is reached over local edges, and how many gates it has."""

HUB_BITS = 16
"""A gate is a number: the rank of a corner with a label, and above it which edge leads there, of those of its own."""

MARKS = LANES

MOST_HUBS = 1 << 16
"""Corners that can have labels: hubs are told by their ranks."""

DIRECTIONS = 3
"""Bits of a run that tell its direction."""

LAST = 1 << 15
"""The bit of a run that tells that it is the last one."""

MOST_MOVES = (LAST >> DIRECTIONS) - 1
"""Moves that a run can tell."""


@inlined
def words_of(index: Words, section: int) -> Words:
    """Return a section of int64."""
    return index[index[section] : index[section + 1]]


@inlined
def integers_of(index: Words, section: int) -> Integers:
    """Return a section of int32; it may have one number more at its end than were put in."""
    return index.view(np.int32)[2 * index[section] : 2 * index[section + 1]]


@inlined
def shorts_of(index: Words, section: int) -> Shorts:
    """Return a section of uint16; it may have up to three numbers more at its end than were put in."""
    return index.view(np.uint16)[4 * index[section] : 4 * index[section + 1]]


@joined
def label_size(entries: int) -> int:
    """Return how many int32 a label takes."""
    return (entries + 1) // 2 + (1 + LINK_SIZE) * entries


@joined
def fringe_size(edges: int, gates: int) -> int:
    """Return how many int32 are told of a corner of the fringe."""
    return FRINGE_HEAD + 2 * gates + 3 * edges


@joined
def edges_after(gates: int) -> int:
    """Return how many int32 after the begin of what is told of a corner of the fringe its edges lie."""
    return FRINGE_HEAD + 2 * gates


@joined
def lengths_after(entries: int) -> int:
    """Return how many int32 after the begin of a label its lengths lie."""
    return (entries + 1) // 2


@joined
def links_after(entries: int) -> int:
    """Return how many int32 after the begin of a label its links lie."""
    return (entries + 1) // 2 + entries


@joined
def direction_of_run(run: int) -> int:
    """Return in which direction a run goes."""
    return run & ((1 << DIRECTIONS) - 1)


@joined
def moves_of_run(run: int) -> int:
    """Return how many moves a run has."""
    return (run >> DIRECTIONS) & MOST_MOVES


@joined
def last_run_of(ways: Shorts, way: int) -> int:
    """Return where the last run of a way lies."""
    place = np.int64(way)
    while ways[np.uint64(place)] < LAST:
        place += 1
    return int(place)


@joined
def moves_of(ways: Shorts, way: int) -> int:
    """Return how many moves a way has."""
    moves = np.int64(0)
    for place in range(way, last_run_of(ways, way) + 1):
        moves += moves_of_run(np.int64(ways[np.uint64(place)]))
    return int(moves)
