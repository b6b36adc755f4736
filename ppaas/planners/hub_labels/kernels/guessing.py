"""Kernel: guess a way between two ends over labels that is hardly longer than a shortest one.

From each corner that an end sees it goes up through the fringe, always to the corner over which the other end seems
nearest. What is longer than the way found so need not be looked at.
"""

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.hubs import lay_out, look_up, take_back_one
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    ENTRIES,
    LABEL,
    LABELS,
    ROW,
    TABLE,
    integers_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers, octile
from ppaas.planners.hub_labels.kernels.scratch import GOAL, START, end_of
from ppaas.planners.hub_labels.kernels.trees import FAR
from ppaas.planners.kernels.bare import bare


@bare
def _ascend(index: Words, corner: int, length: int, to_row: int, to_column: int, most: int) -> tuple[int, int]:
    """Return a corner with a label that is above one, or −1 without a way shorter than ``most``, and how far it is."""
    table, labels = integers_of(index, TABLE), integers_of(index, LABELS)
    while corner >= 0 and table[corner * CORNER_SIZE + ENTRIES] < 0:
        edge, edges = table[corner * CORNER_SIZE + LABEL], -1 - table[corner * CORNER_SIZE + ENTRIES]
        corner, least, passed = -1, most, length
        for i in range(edge, edge + edges):
            at = labels[i] * CORNER_SIZE
            further = passed + labels[i + edges]
            bound = further + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column)
            if bound < least:
                least, corner, length = bound, labels[i], further
    return corner, length


@bare
def _nearest(index: Words, scratch: Integers, end: int, found: int, to_row: int, to_column: int) -> tuple[int, int]:
    """Return that corner with a label, or −1, over which the other end seems nearest, and how far it is."""
    table = integers_of(index, TABLE)
    seen, lengths = end_of(index, scratch, end, 0), end_of(index, scratch, end, 1)
    nearest, beyond, least = np.int64(-1), np.int64(0), np.int64(FAR)
    for i in range(found):
        corner, length = _ascend(index, np.int64(seen[i]), np.int64(lengths[i]), to_row, to_column, least)
        if corner >= 0:
            at = corner * CORNER_SIZE
            bound = length + octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column)
            if bound < least:
                least, nearest, beyond = bound, corner, length
    return int(nearest), int(beyond)


@bare
def guess(
    index: Words, scratch: Integers, found: int, to_found: int, row: int, column: int, to_row: int, to_column: int
) -> int:
    """Return how long the way guessed is between two ends that see so many corners; `FAR` if none is found."""
    corner, length = _nearest(index, scratch, START, found, to_row, to_column)
    to_corner, to_length = _nearest(index, scratch, GOAL, to_found, row, column)
    if corner < 0 or to_corner < 0:
        return int(FAR)
    lay_out(index, scratch, corner, length)
    length = look_up(index, scratch, to_corner) + to_length
    take_back_one(index, scratch, corner)
    return int(min(length, FAR))
