"""Kernel: read a shortest path off an index.

Where the two ends see each other there is nothing to look up. Else each end is joined to the corners it sees; the
labels of the start's corners are laid out in an array by their hubs, and those of the goal's corners look up the hub
over which the way is shortest. From there the links of the labels lead back to both ends.

Few of the corners that an end sees lead to the other end. What a way over a corner is at least, its distances to a few
landmarks tell (Goldberg and Harrelson, "Computing the Shortest Path: A* Search Meets Graph Theory", SODA 2005); corners
over which no way is shorter than one known are left out.
"""

import sys

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ppaas.planners.hub_labels.kernels.bits import Words, down, up
from ppaas.planners.hub_labels.kernels.core_labels import least
from ppaas.planners.hub_labels.kernels.laying import LINK_SHIFT
from ppaas.planners.hub_labels.kernels.layout import (
    CORNERS,
    EDGES,
    END,
    HEAD,
    HUBS,
    LABELS,
    LANDMARK_COUNT,
    LANDMARKS,
    LENGTHS,
    LINKS,
    MOST_SEEN,
    PLACES,
    STEPS,
    TERRAIN,
    WAYS,
    integers_of,
    words_of,
)
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, STRAIGHT, Integers, diagonal_steps, scan
from ppaas.planners.hub_labels.kernels.terrain import (
    COLUMNS,
    ROWS,
    column_line,
    is_corner,
    is_wall,
    number_of,
    row_line,
)
from ppaas.planners.hub_labels.kernels.trees import FAR

ROW_UNIT, COLUMN_UNIT = (1, 1 << 32) if sys.byteorder == "little" else (1 << 32, 1)
"""A cell is written as one int64, which lies in memory as its row and its column do."""

EXPANDED = 0
"""Where in the scratch it is told how many entries of labels were looked at."""

FIXED = 1 + 2 * LANDMARK_COUNT


def scratch_size(corners: int, most_seen: int) -> int:
    """Return how many int32 a query needs to write to; all of them are `FAR` at first."""
    return FIXED + corners + 6 * most_seen + corners + 2


@njit(cache=True, nogil=True, error_model="numpy")
def _octile(rows: int, columns: int) -> int:
    rows, columns = abs(rows), abs(columns)
    return STRAIGHT * max(rows, columns) + (DIAGONAL - STRAIGHT) * min(rows, columns)


@njit(cache=True, nogil=True, error_model="numpy")
def _sees(terrain: Words, row: int, column: int, to_row: int, to_column: int) -> bool:
    """Tell whether the way that goes along the diagonal first and then straight is free."""
    rows, columns = to_row - row, to_column - column
    below, right = 1 if rows > 0 else -1, 1 if columns > 0 else -1
    steps = min(abs(rows), abs(columns))
    if diagonal_steps(terrain, row, column, below, right, steps) < steps:
        return False
    row, column = row + steps * below, column + steps * right
    if row == to_row:
        rest = abs(to_column - column)
        line = row_line(terrain, row)
        return rest == (
            up(terrain, line, 3, column + 1, rest) if right > 0 else down(terrain, line, 3, column - 1, rest)
        )
    rest = abs(to_row - row)
    line = column_line(terrain, column)
    return rest == (up(terrain, line, 2, row + 1, rest) if below > 0 else down(terrain, line, 2, row - 1, rest))


@njit(cache=True, nogil=True, error_model="numpy")
def _join(
    terrain: Words, landmarks: Integers, row: int, column: int, seen: Integers, lengths: Integers, marks: Integers
) -> int:
    """Find the corners that an end sees, itself if it is one, and how far the landmarks are; return how many."""
    if is_corner(terrain, row, column):
        seen[0] = number_of(terrain, row, column)
        lengths[0] = 0
        found = 1
    else:
        found = scan(terrain, row, column, seen, lengths)
    marks[:] = FAR
    for i in range(found):
        own = seen[i] * LANDMARK_COUNT
        for mark in range(LANDMARK_COUNT):
            marks[mark] = min(marks[mark], np.int32(landmarks[own + mark] + lengths[i]))
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _bound(
    landmarks: Integers, places: Integers, found: int, row: int, column: int, marks: Integers,
    seen: Integers, lengths: Integers, bounds: Integers,
) -> int:  # fmt: skip
    """Tell how long the way from one end over each of its corners to the other end is at least; return the best."""
    best = 0
    for i in range(found):
        corner = seen[i]
        bound = np.int32(_octile(places[2 * corner] - row, places[2 * corner + 1] - column))
        for mark in range(LANDMARK_COUNT):
            bound = max(bound, np.int32(abs(landmarks[corner * LANDMARK_COUNT + mark] - marks[mark])))
        bounds[i] = bound + lengths[i]
        if bounds[i] < bounds[best]:
            best = i
    return best


@njit(cache=True, nogil=True, error_model="numpy")
def _swap(i: int, j: int, seen: Integers, lengths: Integers, bounds: Integers) -> None:
    seen[i], seen[j] = seen[j], seen[i]
    lengths[i], lengths[j] = lengths[j], lengths[i]
    bounds[i], bounds[j] = bounds[j], bounds[i]


@njit(cache=True, nogil=True, error_model="numpy")
def _lay_out(reach: Integers, hubs: Integers, far: Integers, begin: int, end: int, length: int) -> None:
    for i in range(begin, end):
        reach[hubs[i]] = min(reach[hubs[i]], np.int32(far[i] + length))


@njit(cache=True, nogil=True, error_model="numpy")
def _entry(hubs: Integers, begin: int, end: int, hub: int) -> int:
    low, high = begin, end - 1
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low


@njit(cache=True, nogil=True, error_model="numpy")
def _follow(
    index: Words, corner: int, entry: int, links: Integers, steps: Integers, route: Integers, at: int, way: int
) -> int:
    """Write the corners from one to the hub of an entry of its label to the route, up or down from a place of it."""
    labels, edges, ways = words_of(index, LABELS), words_of(index, EDGES), words_of(index, WAYS)
    route[at] = corner
    link = links[entry]
    while link >= 0:
        edge = edges[corner] + (link >> LINK_SHIFT)
        for step in range(ways[edge], ways[edge + 1]):
            at += way
            corner = steps[step]
            route[at] = corner
        link = links[labels[corner] + (link & ((1 << LINK_SHIFT) - 1))]
    return at


@njit(cache=True, nogil=True, error_model="numpy")
def _write(cells: Words, at: int, row: int, column: int, to_row: int, to_column: int) -> int:
    """Write the cells of a free way between two that see each other, without the first; return where they end."""
    rows, columns = to_row - row, to_column - column
    down = ROW_UNIT if rows > 0 else -ROW_UNIT
    right = COLUMN_UNIT if columns > 0 else -COLUMN_UNIT
    rows, columns = abs(rows), abs(columns)
    cell = row * ROW_UNIT + column * COLUMN_UNIT
    diagonal = min(rows, columns)
    for i in range(diagonal):
        cell += down + right
        cells[at + i] = cell
    at += diagonal
    straight = max(rows, columns) - diagonal
    step = down if rows > columns else right
    for i in range(straight):
        cell += step
        cells[at + i] = cell
    return at + straight


@njit(cache=True, nogil=True, error_model="numpy")
def _spell(
    places: Integers, route: Integers, corners: int, row: int, column: int, to_row: int, to_column: int
) -> NDArray[np.int32]:
    """Return the cells of the way from one cell over so many corners to another."""
    count, r, c = 1, row, column
    for i in range(corners):
        r_next, c_next = places[2 * route[i]], places[2 * route[i] + 1]
        count += max(abs(r_next - r), abs(c_next - c))
        r, c = r_next, c_next
    count += max(abs(to_row - r), abs(to_column - c))
    cells = np.empty((count, 2), np.int32)
    flat = cells.reshape(2 * count).view(np.int64)
    flat[0] = (row - 1) * ROW_UNIT + (column - 1) * COLUMN_UNIT
    at, r, c = 1, row - 1, column - 1
    for i in range(corners):
        r_next, c_next = places[2 * route[i]] - 1, places[2 * route[i] + 1] - 1
        at = _write(flat, at, r, c, r_next, c_next)
        r, c = r_next, c_next
    _write(flat, at, r, c, to_row - 1, to_column - 1)
    return cells


@njit(cache=True, nogil=True, error_model="numpy")
def _route(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Write the corners of a shortest way to the route in the scratch; return how many, −1 if there is no way."""
    terrain, landmarks = words_of(index, TERRAIN), integers_of(index, LANDMARKS)
    places, labels = integers_of(index, PLACES), words_of(index, LABELS)
    hubs, far, links = integers_of(index, HUBS), integers_of(index, LENGTHS), integers_of(index, LINKS)
    corners, most = index[CORNERS], index[MOST_SEEN]
    marks, to_marks = scratch[1 : 1 + LANDMARK_COUNT], scratch[1 + LANDMARK_COUNT : FIXED]
    reach, route = scratch[FIXED : FIXED + corners], scratch[FIXED + corners : FIXED + 2 * corners + 2]
    rest = scratch[FIXED + 2 * corners + 2 :]
    seen, lengths, bounds = rest[:most], rest[most : 2 * most], rest[2 * most : 3 * most]
    to_seen, to_lengths, to_bounds = rest[3 * most : 4 * most], rest[4 * most : 5 * most], rest[5 * most :]

    found = _join(terrain, landmarks, row, column, seen, lengths, marks)
    to_found = _join(terrain, landmarks, to_row, to_column, to_seen, to_lengths, to_marks)
    if found == 0 or to_found == 0:
        return -1
    _swap(
        0, _bound(landmarks, places, found, to_row, to_column, to_marks, seen, lengths, bounds), seen, lengths, bounds
    )
    first = _bound(landmarks, places, to_found, row, column, marks, to_seen, to_lengths, to_bounds)
    _swap(0, first, to_seen, to_lengths, to_bounds)

    best, best_to, kept, looked = np.int64(FAR), -1, 0, 0
    for i in range(found):
        if bounds[i] >= best:
            continue
        _swap(kept, i, seen, lengths, bounds)
        begin, end = labels[seen[kept]], labels[seen[kept] + 1]
        _lay_out(reach, hubs, far, begin, end, lengths[kept])
        looked += end - begin
        kept += 1
        if i == 0:
            begin, end = labels[to_seen[0]], labels[to_seen[0] + 1]
            best = min(best, np.int64(least(reach, hubs, far, begin, end)) + to_lengths[0])
    for i in range(to_found):
        if i > 0 and to_bounds[i] >= best:
            continue
        begin, end = labels[to_seen[i]], labels[to_seen[i] + 1]
        looked += end - begin
        length = np.int64(least(reach, hubs, far, begin, end)) + to_lengths[i]
        if length < best or (best_to < 0 and length == best):
            best, best_to = length, i
    scratch[EXPANDED] = looked
    if best < FAR:
        count = _walk(index, links, reach, route, kept, seen, lengths, to_seen[best_to], best - to_lengths[best_to])
    else:
        count = -1
    for i in range(kept):
        for entry in range(labels[seen[i]], labels[seen[i] + 1]):
            reach[hubs[entry]] = FAR
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _walk(
    index: Words, links: Integers, reach: Integers, route: Integers, kept: int, seen: Integers, lengths: Integers,
    to_corner: int, length: int,
) -> int:  # fmt: skip
    """Write the corners of the way of that length to a corner of the goal, and return how many they are."""
    labels, hubs, far = words_of(index, LABELS), integers_of(index, HUBS), integers_of(index, LENGTHS)
    steps = integers_of(index, STEPS)
    to_entry = labels[to_corner]
    while reach[hubs[to_entry]] + far[to_entry] != length:
        to_entry += 1
    hub = hubs[to_entry]
    last = len(route) - 1
    back = _follow(index, to_corner, to_entry, links, steps, route, last, -1)
    for i in range(kept):
        entry = _entry(hubs, labels[seen[i]], labels[seen[i] + 1], hub)
        if hubs[entry] == hub and far[entry] + lengths[i] == reach[hub]:
            count = _follow(index, seen[i], entry, links, steps, route, 0, 1)
            for at in range(back, last + 1):
                route[count] = route[at]
                count += 1
            return count
    return -1


@njit(cache=True, nogil=True, error_model="numpy")
def find_path(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> NDArray[np.int32]:
    """Find a shortest path.

    Parameters
    ----------
    index : int64 array
    scratch : (`scratch_size`,) int32 array
        Of the calling thread alone.
    row, column, to_row, to_column : int
        Start and goal, in cells of the map.

    Returns
    -------
    (n, 2) int32 array
        Row and column of each cell; none if there is no way, or an end is not free or not on the map.
    """
    terrain = words_of(index, TERRAIN)
    scratch[EXPANDED] = 0
    rows, columns = terrain[ROWS] - 2, terrain[COLUMNS] - 2
    nowhere = np.empty((0, 2), np.int32)
    if not (0 <= row < rows and 0 <= to_row < rows and 0 <= column < columns and 0 <= to_column < columns):
        return nowhere
    row, column, to_row, to_column = row + 1, column + 1, to_row + 1, to_column + 1
    if is_wall(terrain, row, column) or is_wall(terrain, to_row, to_column):
        return nowhere
    places, corners = integers_of(index, PLACES), index[CORNERS]
    route = scratch[FIXED + corners : FIXED + 2 * corners + 2]
    if _sees(terrain, row, column, to_row, to_column):
        return _spell(places, route, 0, row, column, to_row, to_column)
    count = _route(index, scratch, row, column, to_row, to_column)
    return _spell(places, route, count, row, column, to_row, to_column) if count >= 0 else nowhere


def warm() -> None:
    """Compile and call each kernel once."""
    index = np.zeros(HEAD + 1, np.int64)
    index[TERRAIN : END + 1] = HEAD
    index.flags.writeable = False
    find_path(index, np.full(scratch_size(0, 1), FAR, np.int32), -1, -1, -1, -1)
