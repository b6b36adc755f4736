"""Kernel: read a shortest path off an index.

Where the two ends see each other there is nothing to look up. Else each end is joined to the corners it sees; the
labels of the start's corners are laid out in an array by their hubs, and those of the goal's corners look up the hub
over which the way is shortest. From there the links of the labels lead back to both ends. Where corners have no labels,
both ends first go up through the fringe to those that have.

The two corners of each end over which a way may be shortest give a good way; corners over which none can be shorter are
left out.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit, types

from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.climbing import climb, descend, lead, meet
from ppaas.planners.hub_labels.kernels.guessing import guess
from ppaas.planners.hub_labels.kernels.hubs import lay_out, look_up, take_back, walk
from ppaas.planners.hub_labels.kernels.joining import TRIED, bound_all, join, measure, sees, swap
from ppaas.planners.hub_labels.kernels.layout import (
    COLUMN,
    CORNER_SIZE,
    CORNERS,
    END,
    HEAD,
    LABELLED,
    LANDMARK_COUNT,
    ROW,
    TABLE,
    TERRAIN,
    WAYS,
    integers_of,
    shorts_of,
    words_of,
)
from ppaas.planners.hub_labels.kernels.scan import Integers
from ppaas.planners.hub_labels.kernels.scratch import (
    CORNER,
    COUNT,
    EXPANDED,
    GOAL,
    MEETING,
    MOVES,
    START,
    end_of,
    new_scratch,
    route_of,
)
from ppaas.planners.hub_labels.kernels.terrain import COLUMNS, ROWS, is_wall
from ppaas.planners.hub_labels.kernels.trees import FAR
from ppaas.planners.hub_labels.kernels.writing import (
    Cells,
    new_cells,
    write_back,
    write_first,
    write_straight,
    write_way,
)
from ppaas.planners.kernels.bare import inlined


@inlined
def _lay_best(index: Words, scratch: Integers, found: int, to_found: int, best: int) -> tuple[int, int]:
    """Lay the corners of the start out that matter; return how many, now the first, and how long a way is at most."""
    seen, lengths = end_of(index, scratch, START, 0), end_of(index, scratch, START, 1)
    bounds = end_of(index, scratch, START, 2)
    to_seen, to_lengths = end_of(index, scratch, GOAL, 0), end_of(index, scratch, GOAL, 1)
    tried = min(TRIED, found)
    for i in range(tried):
        lay_out(index, scratch, np.int64(seen[i]), np.int64(lengths[i]))
    for j in range(min(TRIED, to_found)):
        best = min(best, look_up(index, scratch, np.int64(to_seen[j])) + to_lengths[j])
    kept = tried
    for i in range(tried, found):
        if bounds[i] < best:
            swap(kept, i, seen, lengths, bounds)
            lay_out(index, scratch, np.int64(seen[kept]), np.int64(lengths[kept]))
            kept += 1
    return kept, best


@inlined
def _find_route(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> bool:
    """Find a shortest way over corners and write its route; return whether there is one."""
    found, to_found = join(index, scratch, START, row, column), join(index, scratch, GOAL, to_row, to_column)
    shortest, has_fringe = np.int64(FAR), index[LABELLED] < index[CORNERS]
    if has_fringe:
        most = guess(index, scratch, found, to_found, row, column, to_row, to_column)
        found = climb(index, scratch, START, found, to_row, to_column, most)
        to_found = climb(index, scratch, GOAL, to_found, row, column, most)
        shortest, scratch[MEETING] = meet(index, scratch)
    if index[LANDMARK_COUNT]:
        measure(index, scratch, START, found)
        measure(index, scratch, GOAL, to_found)
    bound_all(index, scratch, START, found, to_row, to_column)
    bound_all(index, scratch, GOAL, to_found, row, column)

    kept, most = _lay_best(index, scratch, found, to_found, shortest)
    to_seen, to_lengths = end_of(index, scratch, GOAL, 0), end_of(index, scratch, GOAL, 1)
    to_bounds, last = end_of(index, scratch, GOAL, 2), -1
    for j in range(to_found):
        if j < TRIED or to_bounds[j] < most:
            length = look_up(index, scratch, np.int64(to_seen[j])) + to_lengths[j]
            if length < shortest:
                shortest, last = length, j
                most = min(most, length)
    if last >= 0:
        walk(index, scratch, kept, np.int64(to_seen[last]), shortest - to_lengths[last])
    elif shortest < FAR:
        scratch[COUNT] = lead(index, scratch, START, np.int64(scratch[MEETING]))
        scratch[COUNT + 1] = lead(index, scratch, GOAL, np.int64(scratch[MEETING]))
    scratch[EXPANDED] = take_back(index, scratch, kept)
    if has_fringe:
        descend(index, scratch)
    return bool(shortest < FAR)


@inlined
def _plan(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Find a shortest way, and return of how many cells it is; 0 if there is none."""
    terrain, table = words_of(index, TERRAIN), integers_of(index, TABLE)
    scratch[EXPANDED] = scratch[MOVES] = scratch[COUNT] = scratch[COUNT + 1] = 0
    scratch[CORNER] = scratch[CORNER + 1] = -1
    rows, columns = terrain[ROWS] - 1, terrain[COLUMNS] - 1
    if not (0 < row < rows and 0 < to_row < rows and 0 < column < columns and 0 < to_column < columns):
        return 0
    if is_wall(terrain, row, column) or is_wall(terrain, to_row, to_column):
        return 0
    if sees(terrain, row, column, to_row, to_column):
        return int(max(abs(to_row - row), abs(to_column - column)) + 1)
    if not _find_route(index, scratch, row, column, to_row, to_column):
        return 0
    first, last = scratch[CORNER] * CORNER_SIZE, scratch[CORNER + 1] * CORNER_SIZE
    before = max(abs(table[first + ROW] - row), abs(table[first + COLUMN] - column))
    behind = max(abs(table[last + ROW] - to_row), abs(table[last + COLUMN] - to_column))
    return int(scratch[MOVES] + before + behind + 1)


@inlined
def _spell(index: Words, scratch: Integers, flat: Words, row: int, column: int, to_row: int, to_column: int) -> None:
    """Write the cells of the way that was found."""
    table, ways = integers_of(index, TABLE), shorts_of(index, WAYS)
    route = route_of(index, scratch)
    at = np.int64(write_first(flat, row, column))
    if scratch[CORNER] >= 0:
        first, last = scratch[CORNER] * CORNER_SIZE, scratch[CORNER + 1] * CORNER_SIZE
        to = np.int64(table[first + ROW]), np.int64(table[first + COLUMN])
        at = write_straight(flat, at, row, column, *to)
        for i in range(scratch[COUNT]):
            at = write_way(flat, at, ways, route[i])
        for i in range(len(route) - scratch[COUNT + 1], len(route)):
            at = write_back(flat, at, ways, route[i])
        row, column = int(np.int64(table[last + ROW])), int(np.int64(table[last + COLUMN]))
    write_straight(flat, at, row, column, to_row, to_column)


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
