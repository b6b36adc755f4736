"""Kernel: read a shortest path off an index.

Where the two ends see each other there is nothing to look up. Else each end is joined to the corners it sees; the
labels of the start's corners are laid out in an array by their hubs, and those of the goal's corners look up the hub
over which the way is shortest. From there the links of the labels lead back to both ends.

Few of the corners that an end sees lead to the other end. How long a way over a corner is at least, its distances to
landmarks tell (Goldberg and Harrelson, "Computing the Shortest Path: A* Search Meets Graph Theory", SODA 2005). The two
corners of each end with the least bounds give a good way; corners over which none can be shorter are left out.
"""

from typing import Any

import numpy as np
from numba import njit

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.core_labels import least
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    CORNERS,
    END,
    HEAD,
    LABEL,
    LABELS,
    LANDMARK_COUNT,
    LANDMARKS,
    LINK_SHIFT,
    MARKS,
    MOST_SEEN,
    PLACE_BITS,
    ROW,
    TABLE,
    TERRAIN,
    WAY,
    WAY_CORNERS,
    WAY_HEAD,
    WAY_MOVES,
    WAYS,
    integers_of,
    words_of,
)
from ppaas.planners.hub_labels.kernels.scan import DIAGONAL, STRAIGHT, Integers, diagonal_steps, is_free, scan
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
from ppaas.planners.hub_labels.kernels.writing import Cells, new_cells, write_cells, write_first
from ppaas.planners.kernels import simd
from ppaas.planners.kernels.bare import bare, inlined, joined

lanes: Any = simd  # numba's annotations take what makes an operation for the operation

EXPANDED, FIRST, LAST, FRONT, BACK, MOVES = range(6)
"""What the scratch tells first: how many entries of labels were looked at, the corners next to start and goal, or −1 if
none is between them; how many ways lead from the first to the hub and from the last to the hub; and their moves."""

FIXED = 8 + 2 * MARKS
TRIED = 2
"""Corners of each end that are tried before it is told which are left out."""


def scratch_size(corners: int, most_seen: int) -> int:
    """Return how many int32 a query needs to write to; all of them are `FAR` at first."""
    return FIXED + corners + 2 * (corners + 2) + 6 * most_seen


@inlined
def _route_of(scratch: Integers, corners: int) -> Integers:
    """Return where a route lies: pairs of corner and way, the start's from its front on, the goal's from its end."""
    return scratch[FIXED + corners : FIXED + 3 * corners + 4]


@joined
def _octile(rows: int, columns: int) -> int:
    rows, columns = abs(rows), abs(columns)
    return STRAIGHT * max(rows, columns) + (DIAGONAL - STRAIGHT) * min(rows, columns)


@bare
def _sees(terrain: Words, row: int, column: int, to_row: int, to_column: int) -> bool:
    """Tell whether the way that goes along the diagonal first and then straight is free."""
    rows, columns = to_row - row, to_column - column
    below, right = 1 if rows > 0 else -1, 1 if columns > 0 else -1
    steps = min(abs(rows), abs(columns))
    if diagonal_steps(terrain, row, column, below, right, steps) < steps:
        return False
    row, column = row + steps * below, column + steps * right
    if row == to_row:
        return bool(is_free(terrain, row_line(terrain, row), 3, column, right, abs(to_column - column)))
    return bool(is_free(terrain, column_line(terrain, column), 2, row, below, abs(to_row - row)))


@bare
def _join(
    terrain: Words, landmarks: Integers, count: int, row: int, column: int,
    seen: Integers, lengths: Integers, marks: Integers,
) -> int:  # fmt: skip
    """Find the corners that an end sees, itself if it is one, and how far the landmarks are; return how many."""
    if is_corner(terrain, row, column):
        seen[0] = number_of(terrain, row, column)
        lengths[0] = 0
        found = 1
    else:
        found = scan(terrain, row, column, seen, lengths)
    if count:
        nearest = lanes.splat(FAR)
        for i in range(found):
            nearest = lanes.least(nearest, lanes.add(lanes.load(landmarks, seen[i] * MARKS), lanes.splat(lengths[i])))
        lanes.store(marks, 0, nearest)
    return found


@bare
def _bound(
    landmarks: Integers, count: int, table: Integers, found: int, row: int, column: int, marks: Integers,
    seen: Integers, lengths: Integers, bounds: Integers,
) -> None:  # fmt: skip
    """Tell how long ways from one end over each of its corners to the other end are at least, the best two first."""
    for i in range(found):
        at = seen[i] * CORNER_SIZE
        bound = _octile(table[at + ROW] - row, table[at + COLUMN] - column)
        if count:
            own, other = lanes.load(landmarks, seen[i] * MARKS), lanes.load(marks, 0)
            low = lanes.least(own, other)
            apart = lanes.add(lanes.subtract(own, low), lanes.subtract(other, low))
            bound = max(bound, FAR - lanes.least_of(lanes.subtract(lanes.splat(FAR), apart)))
        bounds[i] = bound + lengths[i]
    for place in range(min(TRIED, found - 1)):
        best = place
        for i in range(place + 1, found):
            if bounds[i] < bounds[best]:
                best = i
        _swap(place, best, seen, lengths, bounds)


@joined
def _swap(i: int, j: int, seen: Integers, lengths: Integers, bounds: Integers) -> None:
    seen[i], seen[j] = seen[j], seen[i]
    lengths[i], lengths[j] = lengths[j], lengths[i]
    bounds[i], bounds[j] = bounds[j], bounds[i]


@joined
def _size_of(table: Integers, corner: int) -> int:
    """Return how many entries a label has."""
    row = np.uint64(corner * CORNER_SIZE + LABEL)
    return int((table[row + np.uint64(CORNER_SIZE)] - table[row]) // 3)


@joined
def _lay_out(reach: Integers, table: Integers, labels: Integers, corner: int, length: int) -> None:
    """Lay a label out by its hubs."""
    begin, size = table[corner * CORNER_SIZE + LABEL], _size_of(table, corner)
    hubs, lengths = labels[begin : begin + size], labels[begin + size : begin + 2 * size]
    for i in range(size):
        hub = np.uint64(hubs[i])
        reach[hub] = min(reach[hub], np.int32(lengths[i] + length))


@joined
def _look_up(reach: Integers, table: Integers, labels: Integers, corner: int) -> int:
    """Return how long the way over the best hub of a label is."""
    begin, size = table[corner * CORNER_SIZE + LABEL], _size_of(table, corner)
    return int(least(reach, labels[begin : begin + size], labels[begin + size : begin + 2 * size], 0, size))


@bare
def _follow(
    table: Integers, labels: Integers, ways: Integers, corner: int, place: int, route: Integers, at: int, way: int,
    scratch: Integers,
) -> int:  # fmt: skip
    """Write the ways from a corner to the hub at a place of its label to the route, and return how many they are."""
    count = 0
    while True:
        row = corner * CORNER_SIZE
        size = (table[row + CORNER_SIZE + LABEL] - table[row + LABEL]) // 3
        link = labels[table[row + LABEL] + 2 * size + place]
        if link < 0:
            return count
        first = table[row + WAY] + (link >> LINK_SHIFT)
        route[at] = corner
        route[at + 1] = first
        at += way
        count += 1
        scratch[MOVES] += ways[first + WAY_MOVES]
        corner = ways[first + WAY_HEAD + ways[first + WAY_CORNERS] - 1]
        place = link & PLACE_BITS


@bare
def _walk(
    index: Words, scratch: Integers, kept: int, seen: Integers, lengths: Integers, to_corner: int, length: int
) -> None:
    """Write the route of that length from one of the corners laid out to a corner of the goal."""
    table, labels, ways = integers_of(index, TABLE), integers_of(index, LABELS), integers_of(index, WAYS)
    reach, route = scratch[FIXED : FIXED + index[CORNERS]], _route_of(scratch, index[CORNERS])
    begin, size = table[to_corner * CORNER_SIZE + LABEL], _size_of(table, to_corner)
    place = 0
    while reach[labels[begin + place]] + labels[begin + size + place] != length:
        place += 1
    hub = labels[begin + place]
    scratch[LAST] = to_corner
    scratch[BACK] = _follow(table, labels, ways, to_corner, place, route, len(route) - 2, -2, scratch)
    for i in range(kept):
        begin, size = table[seen[i] * CORNER_SIZE + LABEL], _size_of(table, seen[i])
        place = _place_of(labels[begin : begin + size], hub)
        if labels[begin + place] == hub and labels[begin + size + place] + lengths[i] == reach[hub]:
            scratch[FIRST] = seen[i]
            scratch[FRONT] = _follow(table, labels, ways, seen[i], place, route, 0, 2, scratch)
            return


@joined
def _place_of(hubs: Integers, hub: int) -> int:
    """Return where a hub is in a label; any place if it is not in it."""
    low, high = 0, len(hubs) - 1
    while low < high:
        middle = (low + high) >> 1
        if hubs[middle] < hub:
            low = middle + 1
        else:
            high = middle
    return low


@bare
def _find_route(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> bool:
    """Find a shortest way over corners and write its route; return whether there is one."""
    landmarks, count = integers_of(index, LANDMARKS), index[LANDMARK_COUNT]
    table, labels = integers_of(index, TABLE), integers_of(index, LABELS)
    corners, most = index[CORNERS], index[MOST_SEEN]
    marks, to_marks = scratch[FIXED - 2 * MARKS : FIXED - MARKS], scratch[FIXED - MARKS : FIXED]
    reach, rest = scratch[FIXED : FIXED + corners], scratch[FIXED + 3 * corners + 4 :]
    seen, lengths, bounds = rest[:most], rest[most : 2 * most], rest[2 * most : 3 * most]
    to_seen, to_lengths, to_bounds = rest[3 * most : 4 * most], rest[4 * most : 5 * most], rest[5 * most :]

    terrain = words_of(index, TERRAIN)
    found = _join(terrain, landmarks, count, row, column, seen, lengths, marks)
    to_found = _join(terrain, landmarks, count, to_row, to_column, to_seen, to_lengths, to_marks)
    _bound(landmarks, count, table, found, to_row, to_column, to_marks, seen, lengths, bounds)
    _bound(landmarks, count, table, to_found, row, column, marks, to_seen, to_lengths, to_bounds)

    best, last, kept = np.int64(FAR), -1, 0
    for i in range(found):
        if i >= TRIED and bounds[i] >= best:
            continue
        _swap(kept, i, seen, lengths, bounds)
        _lay_out(reach, table, labels, seen[kept], lengths[kept])
        kept += 1
        if kept == min(TRIED, found):
            for j in range(min(TRIED, to_found)):
                best = min(best, _look_up(reach, table, labels, to_seen[j]) + to_lengths[j])
    looked = 0
    for j in range(to_found):
        if j < TRIED or to_bounds[j] < best:
            looked += _size_of(table, to_seen[j])
            length = _look_up(reach, table, labels, to_seen[j]) + to_lengths[j]
            if length < best or (last < 0 and length == best and best < FAR):
                best, last = length, j
    if last >= 0:
        _walk(index, scratch, kept, seen, lengths, to_seen[last], best - to_lengths[last])
    for i in range(kept):
        size = _size_of(table, seen[i])
        looked += size
        begin = table[seen[i] * CORNER_SIZE + LABEL]
        for hub in labels[begin : begin + size]:
            reach[np.uint64(hub)] = FAR
    scratch[EXPANDED] = looked
    return last >= 0


@bare
def _plan(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Find a shortest way, and return of how many cells it is; 0 if there is none."""
    terrain, table = words_of(index, TERRAIN), integers_of(index, TABLE)
    scratch[EXPANDED] = scratch[FRONT] = scratch[BACK] = scratch[MOVES] = 0
    scratch[FIRST] = scratch[LAST] = -1
    rows, columns = terrain[ROWS] - 1, terrain[COLUMNS] - 1
    if not (0 < row < rows and 0 < to_row < rows and 0 < column < columns and 0 < to_column < columns):
        return 0
    if is_wall(terrain, row, column) or is_wall(terrain, to_row, to_column):
        return 0
    if _sees(terrain, row, column, to_row, to_column):
        return int(max(abs(to_row - row), abs(to_column - column)) + 1)
    if not _find_route(index, scratch, row, column, to_row, to_column):
        return 0
    first, last = scratch[FIRST] * CORNER_SIZE, scratch[LAST] * CORNER_SIZE
    before = max(abs(table[first + ROW] - row), abs(table[first + COLUMN] - column))
    behind = max(abs(table[last + ROW] - to_row), abs(table[last + COLUMN] - to_column))
    return int(scratch[MOVES] + before + behind + 1)


@bare
def _spell(index: Words, scratch: Integers, flat: Words, row: int, column: int, to_row: int, to_column: int) -> None:
    """Write the cells of the way that was found."""
    table, ways = integers_of(index, TABLE), integers_of(index, WAYS)
    route = _route_of(scratch, index[CORNERS])
    at, r, c = write_first(flat, row, column), row, column
    if scratch[FIRST] >= 0:
        r, c = table[scratch[FIRST] * CORNER_SIZE + ROW], table[scratch[FIRST] * CORNER_SIZE + COLUMN]
        at = write_cells(flat, at, row, column, r, c)
    for i in range(scratch[FRONT]):
        way = route[2 * i + 1]
        for corner in ways[way + WAY_HEAD : way + WAY_HEAD + ways[way + WAY_CORNERS]]:
            place = np.uint64(corner * CORNER_SIZE)
            r_next, c_next = table[place], table[place + np.uint64(COLUMN)]
            at = write_cells(flat, at, r, c, r_next, c_next)
            r, c = r_next, c_next
    for i in range(scratch[BACK] - 1, -1, -1):
        owner, way = route[len(route) - 2 - 2 * i], route[len(route) - 1 - 2 * i]
        for step in range(way + WAY_HEAD + ways[way + WAY_CORNERS] - 2, way + WAY_HEAD - 2, -1):
            corner = ways[np.uint64(step)] if step >= way + WAY_HEAD else owner
            place = np.uint64(corner * CORNER_SIZE)
            r_next, c_next = table[place], table[place + np.uint64(COLUMN)]
            at = write_cells(flat, at, r, c, r_next, c_next)
            r, c = r_next, c_next
    write_cells(flat, at, r, c, to_row, to_column)


@njit(cache=True, nogil=True, error_model="numpy")
def find_path(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> Cells:
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
    row, column, to_row, to_column = row + 1, column + 1, to_row + 1, to_column + 1
    count = _plan(index, scratch, row, column, to_row, to_column)
    if count == 0:
        return np.empty((0, 2), np.int32)
    cells, flat = new_cells(count)
    _spell(index, scratch, flat, row, column, to_row, to_column)
    return cells


def warm() -> None:
    """Compile and call each kernel once."""
    index = np.zeros(HEAD + 1, np.int64)
    index[TERRAIN : END + 1] = HEAD
    index.flags.writeable = False
    find_path(index, np.full(scratch_size(0, 1), FAR, np.int32), -1, -1, -1, -1)
