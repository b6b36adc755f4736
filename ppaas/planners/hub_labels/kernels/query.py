"""Kernel: read a shortest path from an index.

If the ends see each other, nothing is looked up. Otherwise each end is connected to the corners that it sees. The
distances in the labels of the start's corners are scattered into an array indexed by hub, and the labels of the goal's
corners find the hub with the shortest total (hub-label query; Abraham et al., 2011). The links of the labels lead from
there back to both ends. Fringe corners have no labels, their gates replace them. For ends near each other, an upward
search also looks for a path that uses no labelled corner.

Pruning: the most promising corner of each end gives a first path, and corners whose lower bound exceeds its length are
skipped.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types

from ppaas.kernel_cache.decorators import compiled, inlined, joined
from ppaas.planners.hub_labels.kernels.bits import Words
from ppaas.planners.hub_labels.kernels.fringe_exit import exit_fringe, save_visible
from ppaas.planners.hub_labels.kernels.hub_search import (
    clear_labels,
    prefetch_label,
    scatter_label,
    shortest_over,
    write_route,
)
from ppaas.planners.hub_labels.kernels.joining import (
    bound_paths,
    find_visible,
    measure_landmarks,
    prefetch_end,
    sees,
    swap,
    to_ranks,
)
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
    PATHS,
    ROW,
    TABLE,
    TERRAIN,
    integers_of,
    moves_of,
    shorts_of,
    words_of,
)
from ppaas.planners.hub_labels.kernels.path_cells import (
    Cells,
    new_cells,
    write_first,
    write_path,
    write_path_backwards,
    write_straight,
)
from ppaas.planners.hub_labels.kernels.scan import AMBIGUOUS_LENGTH, Integers, moves_in
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
from ppaas.planners.hub_labels.kernels.upward_search import (
    best_meeting,
    may_meet,
    reset_upward_search,
    search_upwards,
    write_upward_path,
)


@joined
def _prefetch_best(index: Words, scratch: Integers, end: int, found: int) -> None:
    """Prefetch the label of the first corner of an end."""
    if found > 0:
        corner = np.int64(end_of(index, scratch, end, SEEN)[0])
        prefetch_label(integers_of(index, TABLE), integers_of(index, LABELS), corner)


@joined
def _select_others(index: Words, scratch: Integers, end: int, found: int, most: int) -> int:
    """Move the corners with a bound below ``most`` to the front, prefetch their labels, and return their number."""
    table, labels = integers_of(index, TABLE), integers_of(index, LABELS)
    seen, lengths = end_of(index, scratch, end, SEEN), end_of(index, scratch, end, LENGTHS)
    bounds, kept = end_of(index, scratch, end, BOUNDS), np.int64(min(1, found))
    for i in range(1, found):
        if bounds[i] < most:
            prefetch_label(table, labels, np.int64(seen[i]))
            swap(kept, i, seen, lengths, bounds)
            kept += 1
    return int(kept)


@inlined
def _search_hubs(index: Words, scratch: Integers, found: int, to_found: int) -> tuple[int, int, int]:
    """Search the hub with the shortest path from start to goal.

    Returns the number of the start's corners whose labels are scattered (they are the first); the length, `FAR` or more
    without a path; and the index of the goal's corner, or −1.
    """
    seen, lengths = end_of(index, scratch, START, SEEN), end_of(index, scratch, START, LENGTHS)
    to_seen, to_lengths = end_of(index, scratch, GOAL, SEEN), end_of(index, scratch, GOAL, LENGTHS)
    to_bounds, most, shortest, last = end_of(index, scratch, GOAL, BOUNDS), np.int64(FAR), np.int64(FAR), np.int64(-1)
    # Try the most promising pair of corners first.
    if found > 0 and to_found > 0:
        scatter_label(index, scratch, np.int64(seen[0]), np.int64(lengths[0]))
        most = min(most, np.int64(shortest_over(index, scratch, np.int64(to_seen[0])) + to_lengths[0]))
    kept = np.int64(_select_others(index, scratch, START, found, most))
    to_kept = np.int64(_select_others(index, scratch, GOAL, to_found, most))
    # Distance of each hub from the start.
    for i in range(1, kept):
        scatter_label(index, scratch, np.int64(seen[i]), np.int64(lengths[i]))
    # Minimum over the hubs of each corner of the goal.
    for j in range(to_kept):
        if j == 0 or to_bounds[j] < most:
            length = np.int64(shortest_over(index, scratch, np.int64(to_seen[j])) + to_lengths[j])
            if length < shortest:
                shortest, last = length, np.int64(j)
                most = min(most, length)
    return int(kept), int(shortest), int(last)


@inlined
def _find_route(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Find a shortest path over corners and write its route; return its length, `FAR` or more without one."""
    found, to_found = (
        find_visible(index, scratch, START, row, column),
        find_visible(index, scratch, GOAL, to_row, to_column),
    )
    to_ranks(index, scratch, START, found)
    to_ranks(index, scratch, GOAL, to_found)
    near, to_near, has_fringe = found, to_found, index[LABELLED] < index[CORNERS]
    # Replace fringe corners by their gates (access nodes).
    if has_fringe:
        save_visible(index, scratch, START, found)
        save_visible(index, scratch, GOAL, to_found)
        found, to_found = exit_fringe(index, scratch, START, found), exit_fringe(index, scratch, GOAL, to_found)
    # Lower bounds from landmarks (ALT) and octile distances.
    if index[LANDMARK_COUNT]:
        measure_landmarks(index, scratch, START, found)
        measure_landmarks(index, scratch, GOAL, to_found)
    bound_paths(index, scratch, START, found, to_row, to_column)
    _prefetch_best(index, scratch, START, found)
    bound_paths(index, scratch, GOAL, to_found, row, column)
    _prefetch_best(index, scratch, GOAL, to_found)
    # Hub-label query.
    kept, shortest, last = _search_hubs(index, scratch, found, to_found)
    # Local query: bidirectional upward search below all labels.
    if has_fringe and may_meet(index, scratch, near, to_near, shortest):
        search_upwards(index, scratch, START, near, to_near, to_row, to_column, shortest)
        search_upwards(index, scratch, GOAL, to_near, near, row, column, shortest)
        length, scratch[MEETING] = best_meeting(index, scratch)
        if length < shortest:
            shortest, last = length, -1
        reset_upward_search(index, scratch)
    # Unpack the route from the links, or from both upward searches.
    if last >= 0:
        to_corner = np.int64(end_of(index, scratch, GOAL, SEEN)[last])
        to_length = np.int64(end_of(index, scratch, GOAL, LENGTHS)[last])
        write_route(index, scratch, kept, to_corner, to_length, shortest - to_length)
    elif shortest < FAR:
        scratch[COUNT] = write_upward_path(index, scratch, START, np.int64(scratch[MEETING]))
        scratch[COUNT + 1] = write_upward_path(index, scratch, GOAL, np.int64(scratch[MEETING]))
    scratch[EXPANDED] = clear_labels(index, scratch, kept)
    return int(shortest)


@inlined
def _count_moves(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Return the number of moves of the route found."""
    table, paths, route = integers_of(index, TABLE), shorts_of(index, PATHS), route_of(index, scratch)
    first, last = scratch[CORNER] * CORNER_SIZE, scratch[CORNER + 1] * CORNER_SIZE
    moves = np.int64(max(abs(table[first + ROW] - row), abs(table[first + COLUMN] - column)))
    moves += max(abs(table[last + ROW] - to_row), abs(table[last + COLUMN] - to_column))
    for i in range(scratch[COUNT]):
        moves += moves_of(paths, route[i])
    for i in range(len(route) - scratch[COUNT + 1], len(route)):
        moves += moves_of(paths, route[i])
    return int(moves)


@inlined
def _find(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> int:
    """Find a shortest path and return its number of cells; 0 without one."""
    terrain = words_of(index, TERRAIN)
    scratch[EXPANDED] = scratch[COUNT] = scratch[COUNT + 1] = 0
    scratch[CORNER] = scratch[CORNER + 1] = -1
    rows, columns = terrain[ROWS] - 1, terrain[COLUMNS] - 1
    if not (0 < row < rows and 0 < to_row < rows and 0 < column < columns and 0 < to_column < columns):
        return 0
    prefetch_end(terrain, row, column)
    prefetch_end(terrain, to_row, to_column)
    if is_wall(terrain, row, column) or is_wall(terrain, to_row, to_column):
        return 0
    if sees(terrain, row, column, to_row, to_column):
        return int(max(abs(to_row - row), abs(to_column - column)) + 1)
    length = _find_route(index, scratch, row, column, to_row, to_column)
    if length >= FAR:
        return 0
    if length < AMBIGUOUS_LENGTH:
        return int(moves_in(length) + 1)
    return int(_count_moves(index, scratch, row, column, to_row, to_column) + 1)


@inlined
def _write_cells(
    index: Words, scratch: Integers, flat: Words, row: int, column: int, to_row: int, to_column: int
) -> None:
    """Write the cells of the path found."""
    table, paths = integers_of(index, TABLE), shorts_of(index, PATHS)
    route = route_of(index, scratch)
    at, cell = write_first(flat, row, column)
    if scratch[CORNER] >= 0:
        first, last = scratch[CORNER] * CORNER_SIZE, scratch[CORNER + 1] * CORNER_SIZE
        to = np.int64(table[first + ROW]), np.int64(table[first + COLUMN])
        at, cell = write_straight(flat, at, cell, row, column, *to)
        for i in range(scratch[COUNT]):
            at, cell = write_path(flat, at, cell, paths, route[i])
        for i in range(len(route) - scratch[COUNT + 1], len(route)):
            at, cell = write_path_backwards(flat, at, cell, paths, route[i])
        row, column = int(np.int64(table[last + ROW])), int(np.int64(table[last + COLUMN]))
    write_straight(flat, at, cell, row, column, to_row, to_column)


@compiled
def find_path(index: Words, scratch: Integers, row: int, column: int, to_row: int, to_column: int) -> Cells:
    """Return a shortest path.

    Parameters
    ----------
    index : int64 array
        The index; read-only.
    scratch : int32 array
        Memory from `scratch.new_scratch` that belongs to the calling thread.
    row, column, to_row, to_column : int
        Start and goal, in cells of the map.

    Returns
    -------
    (n, 2) int32 array
        Row and column of each cell; empty if there is no path, or an end is not free or not on the map.
    """
    row, column, to_row, to_column = row + 1, column + 1, to_row + 1, to_column + 1
    count = _find(index, scratch, row, column, to_row, to_column)
    if count == 0:
        return np.empty((0, 2), np.int32)
    cells, flat = new_cells(count)
    _write_cells(index, scratch, flat, row, column, to_row, to_column)
    return cells


_SIGNATURE = (types.Array(types.int64, 1, "C", readonly=True), types.int32[::1], *4 * (types.int64,))


def entry() -> Callable[[Words, Integers, int, int, int, int], Cells]:
    """Return the compiled entry point of `find_path` for a read-only index.

    A call of it skips numba's type dispatch, which takes a third of a microsecond, and more for read-only arrays.
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
