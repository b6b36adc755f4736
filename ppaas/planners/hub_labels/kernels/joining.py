"""Kernel: join an end of a path to the corners that it sees, and tell how long ways over each of them are at least.

Few of the corners that an end sees lead to the other end. How long a way over a corner is at least, its distances to
landmarks tell (Goldberg and Harrelson, "Computing the Shortest Path: A* Search Meets Graph Theory", SODA 2005).
"""

from typing import Any

import numpy as np

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.fetching import fetch
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    CORNERS,
    LABELLED,
    LANDMARK_COUNT,
    LANDMARK_SHIFT,
    LANDMARKS,
    MARKS,
    RANKS,
    ROW,
    TABLE,
    TERRAIN,
    Shorts,
    integers_of,
    shorts_of,
    words_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers, diagonal_steps, is_free, octile, scan
from ppaas.planners.hub_labels.kernels.scratch import BOUNDS, LENGTHS, SEEN, end_of, marks_of
from ppaas.planners.hub_labels.kernels.terrain import (
    column_line,
    column_stride,
    is_corner,
    number_of,
    row_line,
    row_stride,
)
from ppaas.planners.kernels import simd
from ppaas.planners.kernels.bare import bare, joined

lanes: Any = simd  # numba's annotations take what makes an operation for the operation

TRIED = 2
"""Corners of each end that are tried before it is told which are left out."""

UNREACHED = 0xFFFF
"""How far a landmark is that cannot be reached; nothing is farther."""


@bare
def sees(terrain: Words, row: int, column: int, to_row: int, to_column: int) -> bool:
    """Tell whether the way that goes along the diagonal first and then straight is free."""
    rows, columns = to_row - row, to_column - column
    below, right = 1 if rows > 0 else -1, 1 if columns > 0 else -1
    steps = min(abs(rows), abs(columns))
    if diagonal_steps(terrain, row, column, below, right, steps) < steps:
        return False
    row, column = row + steps * below, column + steps * right
    if row == to_row:
        return bool(
            is_free(terrain, row_line(terrain, row), row_stride(terrain), column, right, abs(to_column - column))
        )
    return bool(is_free(terrain, column_line(terrain, column), column_stride(terrain), row, below, abs(to_row - row)))


@bare
def join(index: Words, scratch: Integers, end: int, row: int, column: int) -> int:
    """Find the corners that an end sees, itself if it is one, and return how many."""
    terrain, ranks = words_of(index, TERRAIN), integers_of(index, RANKS)
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    if is_corner(terrain, row, column):
        seen[0] = ranks[number_of(terrain, row, column)]
        lengths[0] = 0
        return 1
    found = int(scan(terrain, row, column, seen, lengths))
    for i in range(found):
        seen[i] = ranks[np.uint64(seen[i])]
    if index[LANDMARK_COUNT] and index[LABELLED] == index[CORNERS]:
        landmarks = shorts_of(index, LANDMARKS)
        for i in range(found):
            fetch(landmarks, np.int64(seen[i]) * MARKS)
    return found


@bare
def measure(index: Words, scratch: Integers, end: int, found: int) -> None:
    """Tell how far the landmarks are from an end."""
    landmarks, shift = shorts_of(index, LANDMARKS), index[LANDMARK_SHIFT]
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    nearest = lanes.splat(UNREACHED)
    for i in range(found):
        beyond = lanes.splat(lengths[i] >> shift)
        nearest = lanes.least(nearest, lanes.add(lanes.load_shorts(landmarks, seen[i] * MARKS), beyond))
    lanes.store(marks_of(scratch, end), 0, nearest)


@joined
def _apart(landmarks: Shorts, rank: int, marks: Integers) -> int:
    """Return by how much the distances of a corner and of an end to some landmark differ, in units."""
    own, other = lanes.load_shorts(landmarks, rank * MARKS), lanes.load(marks, 0)
    low = lanes.least(own, other)
    apart = lanes.add(lanes.subtract(own, low), lanes.subtract(other, low))
    return int(UNREACHED - lanes.least_of(lanes.subtract(lanes.splat(UNREACHED), apart)))


@bare
def bound_all(index: Words, scratch: Integers, end: int, found: int, to_row: int, to_column: int) -> None:
    """Tell how long ways from one end over each of its corners to the other end are at least, the best two first."""
    table = integers_of(index, TABLE)
    landmarks, has_some, shift = shorts_of(index, LANDMARKS), index[LANDMARK_COUNT] > 0, index[LANDMARK_SHIFT]
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    bounds, marks = end_of(index, scratch, end, BOUNDS), marks_of(scratch, 1 - end)
    for i in range(found):
        at = seen[i] * CORNER_SIZE
        bound = octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column)
        if has_some:
            # Both distances were cut to whole units, that of the end twice.
            bound = max(bound, (_apart(landmarks, seen[i], marks) - 2) << shift)
        bounds[i] = bound + lengths[i]
    for place in range(min(TRIED, found - 1)):
        best = place
        for i in range(place + 1, found):
            if bounds[i] < bounds[best]:
                best = i
        swap(place, best, seen, lengths, bounds)


@joined
def swap(i: int, j: int, seen: Integers, lengths: Integers, bounds: Integers) -> None:
    """Let two corners of an end change places."""
    seen[i], seen[j] = seen[j], seen[i]
    lengths[i], lengths[j] = lengths[j], lengths[i]
    bounds[i], bounds[j] = bounds[j], bounds[i]
