"""Kernel: connect an end to the corners that it sees, and bound the lengths of paths through each of them.

Few of the corners that an end sees lead to the other end. Distances to landmarks give lower bounds (Goldberg and
Harrelson, "Computing the Shortest Path: A* Search Meets Graph Theory", SODA 2005).
"""

from typing import Any

import numpy as np

from ppaas.kernel_cache.decorators import bare, joined
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    FAR,
    LABELLED,
    LANDMARK_COUNT,
    LANDMARK_LANES,
    LANDMARKS,
    RANKS,
    ROW,
    TABLE,
    TERRAIN,
    integers_of,
    words_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers, diagonal_steps, is_free, octile, scan
from ppaas.planners.hub_labels.kernels.scratch import BOUNDS, LENGTHS, SEEN, end_of, landmark_lengths_of
from ppaas.planners.hub_labels.kernels.terrain import (
    column_line,
    column_stride,
    diagonal_line,
    is_corner,
    number_of,
    row_line,
    row_stride,
)
from ppaas.planners.kernels import simd
from ppaas.planners.kernels.prefetch import LINE, WORDS_PER_LINE, fetch

lanes: Any = simd  # `operation` returns intrinsics, which mypy takes for their generators


@bare
def sees(terrain: Words, row: int, column: int, to_row: int, to_column: int) -> bool:
    """Return whether the path along the diagonal and then straight is free."""
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


@joined
def prefetch_end(terrain: Words, row: int, column: int) -> None:
    """Prefetch the lines of the map around an end."""
    across = row_line(terrain, row) + (column >> 6) * row_stride(terrain)
    along = column_line(terrain, column) + (row >> 6) * column_stride(terrain)
    for line in range(-WORDS_PER_LINE, 2 * WORDS_PER_LINE, WORDS_PER_LINE):
        fetch(terrain, np.int64(across + line))
        fetch(terrain, np.int64(along + line))
    for right in (-1, 1):
        fetch(terrain, np.int64(diagonal_line(terrain, row, column, right) + (row >> 6) * 2))


@bare
def find_visible(index: Words, scratch: Integers, end: int, row: int, column: int) -> int:
    """Find the numbers of the corners that an end sees (itself, if it is a corner), and return how many there are."""
    terrain, ranks = words_of(index, TERRAIN), integers_of(index, RANKS)
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    found = 1
    if is_corner(terrain, row, column):
        seen[0] = number_of(terrain, row, column)
        lengths[0] = 0
    else:
        found = int(scan(terrain, row, column, seen, lengths))
    for i in range(found):
        fetch(ranks, np.int64(seen[i]))
    return found


@bare
def to_ranks(index: Words, scratch: Integers, end: int, found: int) -> None:
    """Replace the numbers of corners by their ranks."""
    ranks, seen = integers_of(index, RANKS), end_of(index, scratch, end, SEEN)
    table, landmarks, marks = integers_of(index, TABLE), integers_of(index, LANDMARKS), np.int64(index[LANDMARK_COUNT])
    for i in range(found):
        corner = np.int64(ranks[np.uint64(seen[i])])
        seen[i] = corner
        fetch(table, corner * CORNER_SIZE)
        if marks and corner < index[LABELLED]:
            fetch(landmarks, corner * marks)
            fetch(landmarks, corner * marks + LINE)


@bare
def measure_landmarks(index: Words, scratch: Integers, end: int, found: int) -> None:
    """Compute the distances of an end to the landmarks."""
    landmarks = integers_of(index, LANDMARKS)
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    nearest = lanes.splat(FAR)
    for i in range(found):
        far = lanes.load(landmarks, seen[i] * LANDMARK_LANES)
        nearest = lanes.least(nearest, lanes.add(far, lanes.splat(lengths[i])))
    lanes.store(landmark_lengths_of(scratch, end), 0, nearest)


@bare
def lower_bound_between(scratch: Integers) -> int:
    """Return a lower bound of the distance between the ends from the landmarks."""
    return int(_landmark_bound(landmark_lengths_of(scratch, 0), 0, landmark_lengths_of(scratch, 1)))


@joined
def _landmark_bound(landmarks: Integers, at: int, marks: Integers) -> int:
    """Return the largest difference of the distances of two points to a landmark."""
    own, other = lanes.load(landmarks, at), lanes.load(marks, 0)
    low = lanes.least(own, other)
    apart = lanes.add(lanes.subtract(own, low), lanes.subtract(other, low))
    return int(FAR - lanes.least_of(lanes.subtract(lanes.splat(FAR), apart)))


@bare
def bound_paths(index: Words, scratch: Integers, end: int, found: int, to_row: int, to_column: int) -> None:
    """Compute lower bounds of paths from an end through each of its corners to the other; put the best first."""
    table = integers_of(index, TABLE)
    landmarks, has_some = integers_of(index, LANDMARKS), index[LANDMARK_COUNT] > 0
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    bounds, marks = end_of(index, scratch, end, BOUNDS), landmark_lengths_of(scratch, 1 - end)
    best, least = np.int64(0), np.int64(FAR)
    for i in range(found):
        at = seen[i] * CORNER_SIZE
        bound = octile(table[at + ROW] - to_row, table[at + COLUMN] - to_column)
        if has_some:
            bound = max(bound, _landmark_bound(landmarks, np.int64(seen[i]) * LANDMARK_LANES, marks))
        bound += lengths[i]
        bounds[i] = bound
        if bound < least:
            best, least = np.int64(i), np.int64(bound)
    if found > 0:
        swap(0, best, seen, lengths, bounds)


@joined
def swap(i: int, j: int, seen: Integers, lengths: Integers, bounds: Integers) -> None:
    """Swap two corners of an end."""
    seen[i], seen[j] = seen[j], seen[i]
    lengths[i], lengths[j] = lengths[j], lengths[i]
    bounds[i], bounds[j] = bounds[j], bounds[i]
