"""Kernel: read a shortest path off an index.

Where the two ends see each other there is nothing to look up. Else each end is joined to the corners it sees; the
labels of the start's corners are laid out in an array by their hubs, and those of the goal's corners look up the hub
over which the way is shortest. From there the links of the labels lead back to both ends. Where corners have no labels,
their gates take their place; and ends that are near each other also look for a way below all labels.

The corner of each end over which a way may be shortest gives a good way; corners over which none can be shorter are
left out.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit, types

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.fringe_exit import keep, leave
from ppaas.planners.hub_labels.kernels.hub_search import announce, lay_out, look_up, take_back, walk
from ppaas.planners.hub_labels.kernels.joining import approach, bound_all, join, measure, rank, sees, swap
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    CORNERS,
    END,
    FAR,
    HEAD,
    LABELLED,
    LABELS,
    LANDMARK_COUNT,
    ROW,
    TABLE,
    TERRAIN,
    WAYS,
    integers_of,
    moves_of,
    shorts_of,
    words_of,
)
from ppaas.planners.hub_labels.kernels.path_cells import (
    Cells,
    new_cells,
    write_back,
    write_first,
    write_straight,
    write_way,
)
from ppaas.planners.hub_labels.kernels.scan import TELLING, Integers, moves_in
from ppaas.planners.hub_labels.kernels.scratch import (
    BOUNDS,
    CORNER,
    COUNT,
    EXPANDED,
    GOAL,
    LENGTHS,
    MEETING,
    SEEN,
    START,
    end_of,
    new_scratch,
    route_of,
)
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS, is_wall
from ppaas.planners.hub_labels.kernels.upward_search import climb, descend, lead, may_meet, meet
from ppaas.planners.kernels.jit_decorators import inlined, joined


@joined
def _announce_best(index: Words, scratch: Integers, end: int, found: int) -> None:
    """Begin to bring the label of the first corner of an end."""
    if found > 0:
        corner = np.int64(end_of(index, scratch, end, SEEN)[0])
        announce(integers_of(index, TABLE), integers_of(index, LABELS), corner)


@joined
def _announce_others(index: Words, scratch: Integers, end: int, found: int, most: int) -> int:
    """Let the corners be first over which a way may be below ``most``, bring their labels; return how many they are."""
    table, labels = integers_of(index, TABLE), integers_of(index, LABELS)
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    bounds, kept = end_of(index, scratch, end, BOUNDS), np.int64(min(1, found))
    for i in range(1, found):
        if bounds[i] < most:
            announce(table, labels, np.int64(seen[i]))
            swap(kept, i, seen, lengths, bounds)
            kept += 1
    return int(kept)


@inlined
def _look_up_all(index: Words, scratch: Integers, found: int, to_found: int) -> tuple[int, int, int]:
    """Lay the corners of the start out that matter, and look those of the goal up.

    Returns how many of the start, now the first, were laid out; how long the shortest way is, `FAR` or more without
    one; and over which corner of the goal it leads, −1 over none.
    """
    seen, lengths = end_of(index, scratch, START, SEEN), end_of(index, scratch, START, LENGTHS)
    to_seen, to_lengths = end_of(index, scratch, GOAL, SEEN), end_of(index, scratch, GOAL, LENGTHS)
    to_bounds, most, shortest, last = end_of(index, scratch, GOAL, BOUNDS), np.int64(FAR), np.int64(FAR), np.int64(-1)
    if found > 0 and to_found > 0:
        lay_out(index, scratch, np.int64(seen[0]), np.int64(lengths[0]))
        most = min(most, np.int64(look_up(index, scratch, np.int64(to_seen[0])) + to_lengths[0]))
    kept = np.int64(_announce_others(index, scratch, START, found, most))
    to_kept = np.int64(_announce_others(index, scratch, GOAL, to_found, most))
    for i in range(1, kept):
        lay_out(index, scratch, np.int64(seen[i]), np.int64(lengths[i]))
    for j in range(to_kept):
        if j == 0 or to_bounds[j] < most:
            length = np.int64(look_up(index, scratch, np.int64(to_seen[j])) + to_lengths[j])
            if length < shortest:
                shortest, last = length, np.int64(j)
                most = min(most, length)
    return int(kept), int(shortest), int(last)


@inlined
def _find_route(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Find a shortest way over corners and write its route; return how long it is, `FAR` or more without one."""
    found, to_found = join(index, scratch, START, row, column), join(index, scratch, GOAL, to_row, to_column)
    rank(index, scratch, START, found)
    rank(index, scratch, GOAL, to_found)
    near, to_near, has_fringe = found, to_found, index[LABELLED] < index[CORNERS]
    if has_fringe:
        keep(index, scratch, START, found)
        keep(index, scratch, GOAL, to_found)
        found, to_found = leave(index, scratch, START, found), leave(index, scratch, GOAL, to_found)
    if index[LANDMARK_COUNT]:
        measure(index, scratch, START, found)
        measure(index, scratch, GOAL, to_found)
    bound_all(index, scratch, START, found, to_row, to_column)
    _announce_best(index, scratch, START, found)
    bound_all(index, scratch, GOAL, to_found, row, column)
    _announce_best(index, scratch, GOAL, to_found)
    kept, shortest, last = _look_up_all(index, scratch, found, to_found)
    if has_fringe and may_meet(index, scratch, near, to_near, shortest):
        climb(index, scratch, START, near, to_near, to_row, to_column, shortest)
        climb(index, scratch, GOAL, to_near, near, row, column, shortest)
        length, scratch[MEETING] = meet(index, scratch)
        if length < shortest:
            shortest, last = length, -1
        descend(index, scratch)
    if last >= 0:
        to_corner = np.int64(end_of(index, scratch, GOAL, SEEN)[last])
        to_length = np.int64(end_of(index, scratch, GOAL, LENGTHS)[last])
        walk(index, scratch, kept, to_corner, to_length, shortest - to_length)
    elif shortest < FAR:
        scratch[COUNT] = lead(index, scratch, START, np.int64(scratch[MEETING]))
        scratch[COUNT + 1] = lead(index, scratch, GOAL, np.int64(scratch[MEETING]))
    scratch[EXPANDED] = take_back(index, scratch, kept)
    return int(shortest)


@inlined
def _count_moves(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Return how many moves the way that was found has."""
    table, ways, route = integers_of(index, TABLE), shorts_of(index, WAYS), route_of(index, scratch)
    first, last = scratch[CORNER] * CORNER_SIZE, scratch[CORNER + 1] * CORNER_SIZE
    moves = np.int64(max(abs(table[first + ROW] - row), abs(table[first + COLUMN] - column)))
    moves += max(abs(table[last + ROW] - to_row), abs(table[last + COLUMN] - to_column))
    for i in range(scratch[COUNT]):
        moves += moves_of(ways, route[i])
    for i in range(len(route) - scratch[COUNT + 1], len(route)):
        moves += moves_of(ways, route[i])
    return int(moves)


@inlined
def _plan(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Find a shortest way, and return of how many cells it is; 0 if there is none."""
    terrain = words_of(index, TERRAIN)
    scratch[EXPANDED] = scratch[COUNT] = scratch[COUNT + 1] = 0
    scratch[CORNER] = scratch[CORNER + 1] = -1
    rows, columns = terrain[ROWS] - 1, terrain[COLUMNS] - 1
    if not (0 < row < rows and 0 < to_row < rows and 0 < column < columns and 0 < to_column < columns):
        return 0
    approach(terrain, row, column)
    approach(terrain, to_row, to_column)
    if is_wall(terrain, row, column) or is_wall(terrain, to_row, to_column):
        return 0
    if sees(terrain, row, column, to_row, to_column):
        return int(max(abs(to_row - row), abs(to_column - column)) + 1)
    length = _find_route(index, scratch, row, column, to_row, to_column)
    if length >= FAR:
        return 0
    if length < TELLING:
        return int(moves_in(length) + 1)
    return int(_count_moves(index, scratch, row, column, to_row, to_column) + 1)


@inlined
def _spell(index: Words, scratch: Integers, flat: Words, row: int, column: int, to_row: int, to_column: int) -> None:
    """Write the cells of the way that was found."""
    table, ways = integers_of(index, TABLE), shorts_of(index, WAYS)
    route = route_of(index, scratch)
    at, cell = write_first(flat, row, column)
    if scratch[CORNER] >= 0:
        first, last = scratch[CORNER] * CORNER_SIZE, scratch[CORNER + 1] * CORNER_SIZE
        to = np.int64(table[first + ROW]), np.int64(table[first + COLUMN])
        at, cell = write_straight(flat, at, cell, row, column, *to)
        for i in range(scratch[COUNT]):
            at, cell = write_way(flat, at, cell, ways, route[i])
        for i in range(len(route) - scratch[COUNT + 1], len(route)):
            at, cell = write_back(flat, at, cell, ways, route[i])
        row, column = int(np.int64(table[last + ROW])), int(np.int64(table[last + COLUMN]))
    write_straight(flat, at, cell, row, column, to_row, to_column)


@njit(cache=True, nogil=True, error_model="numpy")
def find_path(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> Cells:
    """Find a shortest path.

    Parameters
    ----------
    index : int64 array
    scratch : int32 array
        As `scratch.new_scratch` makes it, of the calling thread alone.
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


_SIGNATURE = (types.Array(types.int64, 1, "C", readonly=True), types.int32[::1], *4 * (types.int64,))


def entry() -> Callable[[Words, Integers, int, int, int, int], Cells]:
    """Return `find_path` as it is compiled, for an index that nobody can write to.

    A call of it does not look up which types it is given: that takes a third of a microsecond, and for what is
    read-only more.
    """
    dispatcher: Any = find_path
    dispatcher.compile(_SIGNATURE)
    found: Callable[[Words, Integers, int, int, int, int], Cells] = dispatcher.overloads[_SIGNATURE].entry_point
    return found


def warm() -> None:
    """Compile and call each kernel once."""
    index = np.zeros(HEAD + 1, np.int64)
    index[TERRAIN : END + 1] = HEAD
    index.flags.writeable = False
    entry()(index, new_scratch(index), -1, -1, -1, -1)
