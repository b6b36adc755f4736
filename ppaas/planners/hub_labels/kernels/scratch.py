"""Scratch memory of a query: one int32 array that belongs to one thread.

It begins with `FIXED` numbers: results of the last query, and the distances of its two ends to the landmarks. Then, for
n corners of which k are labelled: the distance of each hub from the start (k); the route (2 n + 2); and for each end
`END_PARTS` lists. An index with a fringe also has, for each end, a record per corner (n): its distance, the path to it,
the corner at which that path begins, and the list of reached corners. Last comes a heap.

All numbers are `FAR` at first. Distances of hubs and corners are `FAR` again after each query.
"""

from typing import Any

import numpy as np

from ppaas.kernel_cache.decorators import inlined, joined
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import CORNERS, FAR, LABELLED, LANDMARK_LANES, MOST_SEEN
from ppaas.planners.hub_labels.kernels.scan import Integers

EXPANDED, MEETING = range(2)
"""Results: number of label entries examined, and the corner at which both upward searches met, or −1."""

CORNER, COUNT, TOUCHED = 3, 5, 7
"""Results of each end: the first corner of its part of the route, or −1 if the ends see each other; the number of paths
in its part; and the number of fringe corners that it reached."""

SEEN, LENGTHS, BOUNDS, NEAR, NEAR_LENGTHS, END_PARTS = range(6)
"""Lists of an end: labelled corners through which paths lead, their distances, and lower bounds of paths through them;
with a fringe, also the corners that it sees and their distances."""

LENGTH_SO_FAR, PATH_TO, PARENT, REACHED, RECORD = range(5)
"""Record of a corner in the upward search of an end: distance, path to it, and corner at which that path begins. The
last number is a list of its own: the i-th reached corner."""

FIXED = 16 + 2 * LANDMARK_LANES
"""Numbers before the distances of hubs."""

_number: Any = np.int64

START, GOAL = _number(0), _number(1)
"""The ends. They are numpy integers, as are other initial values in kernels: numba would compile a kernel once more for
a literal integer."""


@joined
def _of_ends(index: Words) -> int:
    return int(FIXED + index[LABELLED] + 2 * index[CORNERS] + 2)


@joined
def _of_fringe(index: Words) -> int:
    return int(_of_ends(index) + 2 * END_PARTS * index[MOST_SEEN])


@joined
def _of_heap(index: Words) -> int:
    return int((_of_fringe(index) + 2 * RECORD * index[CORNERS] + 1) // 2 * 2)


def new_scratch(index: Words) -> Integers:
    """Return scratch memory for queries on an index."""
    fringe = index[LABELLED] < index[CORNERS]
    scratch = np.full(_of_heap(index) + 2 * int(index[CORNERS]) if fringe else _of_fringe(index), FAR, np.int32)
    scratch[EXPANDED] = 0
    return scratch


@inlined
def landmark_lengths_of(scratch: Integers, end: int) -> Integers:
    """Return the distances of an end to the landmarks."""
    return scratch[FIXED - (2 - end) * LANDMARK_LANES : FIXED - (1 - end) * LANDMARK_LANES]


@inlined
def reach_of(index: Words, scratch: Integers) -> Integers:
    """Return the distance of each hub from the start."""
    return scratch[FIXED : FIXED + index[LABELLED]]


@inlined
def route_of(index: Words, scratch: Integers) -> Integers:
    """Return the route: paths of the start from the front, paths of the goal from the back."""
    return scratch[FIXED + index[LABELLED] : FIXED + index[LABELLED] + 2 * index[CORNERS] + 2]


@joined
def side_of(route: Integers, end: int) -> tuple[int, int]:
    """Return the first index of an end in the route, and the step to its next path."""
    return (0, 1) if end == START else (len(route) - 1, -1)


@inlined
def end_of(index: Words, scratch: Integers, end: int, kind: int) -> Integers:
    """Return a list of an end."""
    begin = _of_ends(index) + (END_PARTS * end + kind) * index[MOST_SEEN]
    return scratch[begin : begin + index[MOST_SEEN]]


@inlined
def fringe_of(index: Words, scratch: Integers, end: int) -> Integers:
    """Return the records of all corners in the upward search of an end, `RECORD` numbers each."""
    begin = _of_fringe(index) + RECORD * end * index[CORNERS]
    return scratch[begin : begin + RECORD * index[CORNERS]]


@inlined
def heap_of(index: Words, scratch: Integers) -> Words:
    """Return the memory of the heap."""
    return scratch[_of_heap(index) :].view(np.int64)
