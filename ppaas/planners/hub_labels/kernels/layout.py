"""Layout of an index: one int64 array with a header of `HEAD` words and then sections that each start at a whole word.

Corners are named by rank, 0 is the most important. The table has `CORNER_SIZE` int32 numbers for each corner: its row
and column, including the margin; the offset of its label; and the number of entries of the label.

The most important corners are *labelled*. If all labels would take too much space, the other corners form the *fringe*.
For a fringe corner, the number of entries is −1 − the number of its edges to more important corners. Its label consists
of `FRINGE_HEAD` numbers: the bounding rectangle of the corners that it reaches over local edges, and the number of its
gates (access nodes). Then follow the gates (see `HUB_BITS`), their distances, and the edges: the corners at their ends,
their lengths (negative for edges that are not local), and their paths.

Labels are int32. The label of a corner has the hubs of all entries, two to a number, then their distances, then their
links. A link has two numbers: the offset of the link of the same hub in the label of the next corner towards the hub
(−1 if that is the hub itself); and the offset of the path to that corner (−1 in the hub's own label).

Paths are uint16 runs. A *run* has a direction, above it the number of moves in that direction, and above that a flag
for the last run of a path. Following links thus reads one place per edge, and writing cells reads runs in sequence.
"""

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import inlined, joined
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.simd import LANES

Shorts = NDArray[np.uint16]

HEAD = 32
"""Length of the header [words]."""

MAGIC, VERSION, SIZE, CHECK, FINGERPRINT = range(5)
"""Header: format marker, version, number of words, checksum of the header, fingerprint of the map."""

CORNERS, LABELLED, MOST_SEEN, LANDMARK_COUNT = range(8, 12)
"""Header: number of corners, number of labelled corners, most corners that a cell may see, and number of landmarks (0
or `LANDMARK_LANES`)."""

TERRAIN, TABLE, LANDMARKS, LABELS, PATHS, RANKS, END = range(12, 19)
"""Header: begin of the sections. The map as lines of bits (int64); the table of corners; distances of labelled corners
to the landmarks, `FAR` if there is no path; the labels; the paths; and the rank of each corner, row by row, followed
by the number of contracted corners (int32)."""

ROW, COLUMN, LABEL, ENTRIES, CORNER_SIZE = range(5)
"""Numbers of a corner in the table."""

LINK_NEXT, LINK_PATH, LINK_SIZE = range(3)
"""Numbers of a link."""

FAR = np.int32(2**30)
"""Infinite distance."""

TOP, BOTTOM, LEFTMOST, RIGHTMOST, GATE_COUNT, FRINGE_HEAD = range(6)
"""Numbers of a fringe corner: bounding rectangle of the corners that it reaches over local edges, number of gates."""

HUB_BITS = 16
"""A gate is a number: the rank of a labelled corner in the lower bits, and above it the index of the corner's own edge
that leads there."""

LANDMARK_LANES = LANES
"""Number of landmarks, if any: one SIMD vector."""

MOST_HUBS = 1 << 16
"""Largest number of labelled corners: hubs are uint16 ranks."""

DIRECTIONS = 3
"""Bits of a run for its direction."""

LAST = 1 << 15
"""Bit of the last run of a path."""

MOST_MOVES = (LAST >> DIRECTIONS) - 1
"""Largest number of moves of a run."""


@inlined
def words_of(index: Words, section: int) -> Words:
    """Return an int64 section."""
    return index[index[section] : index[section + 1]]


@inlined
def integers_of(index: Words, section: int) -> Integers:
    """Return an int32 section; it may end with one padding number."""
    return index.view(np.int32)[2 * index[section] : 2 * index[section + 1]]


@inlined
def shorts_of(index: Words, section: int) -> Shorts:
    """Return a uint16 section; it may end with up to three padding numbers."""
    return index.view(np.uint16)[4 * index[section] : 4 * index[section + 1]]


@joined
def label_size(entries: int) -> int:
    """Return the size of a label [int32]."""
    return (entries + 1) // 2 + (1 + LINK_SIZE) * entries


@joined
def fringe_size(edges: int, gates: int) -> int:
    """Return the size of the numbers of a fringe corner [int32]."""
    return FRINGE_HEAD + 2 * gates + 3 * edges


@joined
def edges_after(gates: int) -> int:
    """Return the offset of the edges in the numbers of a fringe corner [int32]."""
    return FRINGE_HEAD + 2 * gates


@joined
def lengths_after(entries: int) -> int:
    """Return the offset of the distances in a label [int32]."""
    return (entries + 1) // 2


@joined
def links_after(entries: int) -> int:
    """Return the offset of the links in a label [int32]."""
    return (entries + 1) // 2 + entries


@joined
def direction_of_run(run: int) -> int:
    """Return the direction of a run."""
    return run & ((1 << DIRECTIONS) - 1)


@joined
def moves_of_run(run: int) -> int:
    """Return the number of moves of a run."""
    return (run >> DIRECTIONS) & MOST_MOVES


@joined
def last_run_of(paths: Shorts, path: int) -> int:
    """Return the index of the last run of a path."""
    place = np.int64(path)
    while paths[np.uint64(place)] < LAST:
        place += 1
    return int(place)


@joined
def moves_of(paths: Shorts, path: int) -> int:
    """Return the number of moves of a path."""
    moves = np.int64(0)
    for place in range(path, last_run_of(paths, path) + 1):
        moves += moves_of_run(np.int64(paths[np.uint64(place)]))
    return int(moves)
