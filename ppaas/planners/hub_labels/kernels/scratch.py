"""How what a query writes to lies in one array of int32, which belongs to one thread.

It begins with `FIXED` numbers: what is told of the last query, and how far the landmarks are from its two ends. Then,
for n corners of which k have labels: for each hub how far it is from the start (k); the route (2 n + 2); and of each
end `END_PARTS` lists. Where there is a fringe, each end also has of each corner (n) how far it is, the way to it, and
the corner where that way begins; and the corners which were reached. Last comes a heap.

All of it is `FAR` at first, and the numbers of hubs and of how far corners are, again after each query.
"""

from typing import Any

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import CORNERS, FAR, LABELLED, MARKS, MOST_SEEN
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.kernels.jit_decorators import inlined, joined

EXPANDED, MEETING = range(2)
"""What is told first: how many entries of labels were looked at, and the corner where the two ends met below all
labels, or −1."""

CORNER, COUNT, TOUCHED = 3, 5, 7
"""What is told of each end: the corner next to it on the route, or −1 if none is between the ends; how many ways of the
route are its own; and how many corners it reached in the fringe."""

SEEN, LENGTHS, BOUNDS, JOINED, JOINED_LENGTHS, END_PARTS = range(6)
"""What lists an end has: the corners with labels over which ways lead, how far they are, and how long ways over them
are at least; and, where there is a fringe, the corners it sees and how far those are."""

FAR_OFF, WAY, BELOW, REACHED, SPOT = range(5)
"""What an end that climbs tells of each corner, side by side: how far it is, the way to it and the corner where that
begins; and of the first ones which corners it reached, in their order."""

FIXED = 16 + 2 * MARKS

_number: Any = np.int64
START, GOAL = _number(0), _number(1)
"""The ends. They are numbers of numpy, and so are others that kernels begin to count with: whatever is given a plain
number is compiled for that number alone, and once more for all others."""


@joined
def _of_ends(index: Words) -> int:
    return int(FIXED + index[LABELLED] + 2 * index[CORNERS] + 2)


@joined
def _of_fringe(index: Words) -> int:
    return int(_of_ends(index) + 2 * END_PARTS * index[MOST_SEEN])


@joined
def _of_heap(index: Words) -> int:
    return int((_of_fringe(index) + 2 * SPOT * index[CORNERS] + 1) // 2 * 2)


def new_scratch(index: Words) -> Integers:
    """Return the scratch for queries of an index."""
    fringe = index[LABELLED] < index[CORNERS]
    scratch = np.full(_of_heap(index) + 2 * int(index[CORNERS]) if fringe else _of_fringe(index), FAR, np.int32)
    scratch[EXPANDED] = 0
    return scratch


@inlined
def marks_of(scratch: Integers, end: int) -> Integers:
    """Return how far landmarks are from an end: 0 the start, 1 the goal."""
    return scratch[FIXED - (2 - end) * MARKS : FIXED - (1 - end) * MARKS]


@inlined
def reach_of(index: Words, scratch: Integers) -> Integers:
    """Return how far each hub is from the start."""
    return scratch[FIXED : FIXED + index[LABELLED]]


@inlined
def route_of(index: Words, scratch: Integers) -> Integers:
    """Return the route: ways, those of the start from the front on, those of the goal from the end."""
    return scratch[FIXED + index[LABELLED] : FIXED + index[LABELLED] + 2 * index[CORNERS] + 2]


@joined
def side_of(route: Integers, end: int) -> tuple[int, int]:
    """Return where the ways of an end begin on the route, and by how much further the next one is."""
    return (0, 1) if end == START else (len(route) - 1, -1)


@inlined
def end_of(index: Words, scratch: Integers, end: int, what: int) -> Integers:
    """Return a list of an end."""
    begin = _of_ends(index) + (END_PARTS * end + what) * index[MOST_SEEN]
    return scratch[begin : begin + index[MOST_SEEN]]


@inlined
def fringe_of(index: Words, scratch: Integers, end: int) -> Integers:
    """Return what is told of each corner by an end that climbs: `SPOT` numbers each."""
    begin = _of_fringe(index) + SPOT * end * index[CORNERS]
    return scratch[begin : begin + SPOT * index[CORNERS]]


@inlined
def heap_of(index: Words, scratch: Integers) -> Words:
    """Return room for a heap of corners."""
    return scratch[_of_heap(index) :].view(np.int64)
