"""Kernel: grow a field of costs from its goals outward, tile by tile, on all threads.

Tiles wait with the least value that a neighbour would better in them. A round takes all whose value is within `DELTA`
of the least that waits, and works on each of them until nothing changes within it; the threads take one after the
other from a common counter. What they would better in their neighbours is gathered after the round. As values are whole
numbers that only fall, and nobody stops before none can fall, the field is the same whoever comes first.
"""

from typing import Any

import numpy as np
from numba import njit, prange
from numpy.typing import NDArray

from ppaas.planners.kernels import simd
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED, SETTLED
from ppaas.planners.kernels.propagation import TOO_NARROW
from ppaas.planners.kernels.tile_layout import (
    BASE,
    CELL_SHIFT,
    CELLS,
    GOAL,
    LAID,
    LIMIT,
    SIDE,
    TABLE,
    TOUCHED,
    UNREACHED,
)
from ppaas.planners.kernels.tile_plane import SCRATCH
from ppaas.planners.kernels.tile_setup import lay_tile
from ppaas.planners.kernels.tile_visit import OVERLONG, REPORT, WORK, visit

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]
Marks = NDArray[np.uint16]
Places = NDArray[np.int32]

BATCH = 1024
"""Most tiles in one round: 1 ms of work."""

WORTH = 1_600
"""Lines of work that another thread is woken for: 10 µs."""

DELTA = SIDE * BASE // 2
"""Values that one round covers: half the way through a tile."""

PATIENCE = SIDE * BASE // 2
"""How much longer a tile waits where nobody has been, so that more of its neighbours are through before it is begun."""

PER_VISIT = 30
"""Lines that the work around a visit is worth."""

PER_TABLE = 10
"""Lines that filling a table is worth."""

STATE_SIZE = 4
WAITING, ROUNDS, VISITS, PACE = range(STATE_SIZE)
"""Of the state: how many tiles wait, rounds and visits so far, and lines that a visit took in the last round."""


@njit(cache=True, nogil=True, error_model="numpy")
def _bare_around(marks: Marks, tile: Int, reach: Int, across: Int, tiles: Int, bare: Places, count: Int) -> Int:
    """Add to ``bare`` the tiles up to so many away whose tables are not filled; return how many it has."""
    column = tile % across
    for row in range(tile // across - reach, tile // across + reach + 1):
        for beside in range(row * across + max(column - reach, 0), row * across + min(column + reach, across - 1) + 1):
            if 0 <= beside < tiles and not marks[beside] & LAID:
                marks[beside] |= LAID
                bare[count] = beside
                count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def seed_tiles(
    source: Bytes, height: int, width: int, unknown: int, field: Numbers, tables: Numbers, costs: Bytes,
    across: int, tiles: int, keys: Numbers, marks: Marks, waiting: Places, bare: Places, state: Ints, cells: Ints,
) -> None:  # fmt: skip
    """Put the goals into a field in which nobody has been.

    Parameters
    ----------
    source, height, width, unknown, field, tables, costs, across, tiles, keys, marks, waiting, bare, state
        As in `grow_tiles`.
    cells : (n,) int64 array
        Elements of the field; one may be named twice.
    """
    for cell in cells:
        tile = cell >> CELL_SHIFT
        if not marks[tile] & TOUCHED:
            for place in range(_bare_around(marks, tile, 1, across, tiles, bare, 0)):
                lay_tile(source, height, width, unknown, across, np.int64(bare[place]), costs, tables)
            for inner in range(CELLS):
                field[tile * CELLS + inner] = UNREACHED
            keys[tile] = 0
            marks[tile] |= TOUCHED | 1 << GOAL
            waiting[state[WAITING]] = tile
            state[WAITING] += 1
        field[cell] = 0


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(keys: Numbers, marks: Marks, waiting: Places, count: Int) -> tuple[Int, Int]:
    """Return the least key that waits, and the least with the patience that tiles are waited for with."""
    least, nearest = np.int64(UNREACHED), np.int64(UNREACHED) + PATIENCE
    for place in range(count):
        tile = waiting[place]
        key = np.int64(keys[tile])
        least = min(least, key)
        nearest = min(nearest, key if marks[tile] & TOUCHED else key + PATIENCE)
    return least, nearest


@njit(cache=True, nogil=True, error_model="numpy")
def _choose(
    keys: Numbers, marks: Marks, waiting: Places, count: Int, most: Int, chosen: Places, reasons: Marks
) -> tuple[Int, Int]:
    """Take the tiles of one round from those that wait; return how many they are, and how many wait on."""
    taken, kept = 0, 0
    for place in range(count):
        tile = waiting[place]
        key = np.int64(keys[tile])
        if taken < BATCH and (key if marks[tile] & TOUCHED else key + PATIENCE) <= most:
            chosen[taken], reasons[taken] = tile, marks[tile]
            keys[tile], marks[tile] = UNREACHED, TOUCHED | marks[tile] & LAID
            taken += 1
        else:
            waiting[kept] = tile
            kept += 1
    return taken, kept


@njit(cache=True, nogil=True, error_model="numpy")
def _to_lay(marks: Marks, chosen: Places, reasons: Marks, taken: Int, across: Int, tiles: Int, bare: Places) -> Int:
    """Write to ``bare`` the tiles whose tables the round after this may need; return how many.

    A visit reads the tables of the tiles around, and wakes some of those: so two tiles ahead of each that is begun.
    """
    count: Int = 0
    for place in range(taken):
        reason = np.int64(reasons[place])
        if not reason & TOUCHED or (reason >> GOAL) & 1:
            count = _bare_around(marks, np.int64(chosen[place]), 2, across, tiles, bare, count)
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _gather(
    keys: Numbers, marks: Marks, waiting: Places, count: Int, chosen: Places, taken: Int, reports: Numbers, across: Int
) -> tuple[Int, Int, bool]:
    """Let tiles wait that a round would better; return how many wait, lines done, and whether values are too large."""
    moves = (-across, across, -1, 1, -across - 1, -across + 1, across - 1, across + 1)
    work: Int = 0
    overlong = False
    for place in range(taken):
        report = place * REPORT
        work += np.int64(reports[report + WORK]) + PER_VISIT
        overlong |= reports[report + OVERLONG] != 0
        for move in range(8):
            key = reports[report + move]
            if key == UNREACHED:
                continue
            tile = chosen[place] + moves[move]
            if keys[tile] == UNREACHED:
                waiting[count] = tile
                count += 1
            keys[tile] = min(keys[tile], key)
            marks[tile] |= 1 << (move ^ 1 if move < 4 else move ^ 3)
    return count, work, overlong


@njit(cache=True, nogil=True, error_model="numpy", parallel=True)
def grow_tiles(
    source: Bytes, height: int, width: int, unknown: int, field: Numbers, tables: Numbers, costs: Bytes,
    across: int, tiles: int, keys: Numbers, marks: Marks, waiting: Places, chosen: Places, reasons: Marks,
    bare: Places, reports: Numbers, scratch: Numbers, counter: Ints, state: Ints,
    target: int, budget: int, threads: int,
) -> int:  # fmt: skip
    """Work until ``budget`` lines of tiles are done, and tell why it stopped.

    Parameters
    ----------
    source, height, width, unknown
        As in `ppaas.planners.kernels.tile_setup`.
    field, tables, costs
        As in `ppaas.planners.kernels.tile_layout`.
    across, tiles : int
        Tiles side by side, and in all.
    keys : (tiles + 1,) uint32 array
        What each tile waits with; `UNREACHED` if it does not wait.
    marks : (tiles + 1,) uint16 array
        Who woke each tile, whether somebody has been there, and whether its table is filled.
    waiting : (tiles,) int32 array
        The tiles that wait, in any order.
    chosen, reasons : (BATCH,) arrays
        For the tiles of a round and who woke them.
    bare : (25 · BATCH,) int32 array
        For the tiles whose tables are filled during a round.
    reports : (BATCH · REPORT,) uint32 array
        For what comes of each.
    scratch : (threads, SCRATCH) uint32 array
        Each thread's own.
    counter : (1,) int64 array
    state : (STATE_SIZE,) int64 array
    target : int
        Element of the field whose value is wanted; −1 to go on until all are reached.
    budget : int
        Lines to do before it pauses, give or take a round.
    threads : int
        Threads to use; with one, no parallel region is entered.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED or TOO_NARROW, as in `ppaas.planners.kernels.propagation`.
    """
    outcome = EXHAUSTED
    while state[WAITING] > 0:
        least, nearest = _nearest(keys, marks, waiting, state[WAITING])
        if target >= 0 and marks[target >> CELL_SHIFT] & TOUCHED and np.int64(field[target]) <= least:
            outcome = SETTLED
        elif least > LIMIT:
            outcome = TOO_NARROW
        elif budget <= 0:
            outcome = PAUSED
        if outcome != EXHAUSTED:
            break
        taken, kept = _choose(keys, marks, waiting, state[WAITING], nearest + DELTA, chosen, reasons)
        bared = _to_lay(marks, chosen, reasons, taken, across, tiles, bare)
        items = bared + taken
        if threads == 1 or taken * state[PACE] + bared * PER_TABLE < WORTH:
            for item in range(items):
                _do(
                    source, height, width, unknown, field, tables, costs, across, tiles,
                    chosen, reasons, bare, bared, item, scratch[0], reports,
                )  # fmt: skip
        else:
            counter[0] = 0
            for thread in prange(threads):
                while True:
                    item = simd.next_number(counter)
                    if item >= items:
                        break
                    _do(
                        source, height, width, unknown, field, tables, costs, across, tiles,
                        chosen, reasons, bare, bared, item, scratch[thread], reports,
                    )  # fmt: skip
        state[ROUNDS] += 1
        state[VISITS] += taken
        waits, work, overlong = _gather(keys, marks, waiting, kept, chosen, taken, reports, across)
        state[WAITING] = waits
        state[PACE] = work // taken
        budget -= int(work + bared * PER_TABLE)
        if overlong:
            outcome = TOO_NARROW
            break
    return outcome


@njit(cache=True, nogil=True, error_model="numpy")
def _do(
    source: Bytes, height: Int, width: Int, unknown: Int, field: Numbers, tables: Numbers, costs: Bytes,
    across: Int, tiles: Int, chosen: Places, reasons: Marks, bare: Places, bared: Int, item: Int,
    scratch: Numbers, reports: Numbers,
) -> None:  # fmt: skip
    """Do one thing of a round: the first items are tables to fill, the others tiles to visit."""
    place = item - bared
    if place < 0:
        lay_tile(source, height, width, unknown, across, np.int64(bare[item]), costs, tables)
        return
    reason, tile = np.int64(reasons[place]), np.int64(chosen[place])
    visit(field, tables, costs, across, tiles, tile, reason, reason & TOUCHED == 0, scratch, reports, place * REPORT)


def warm() -> None:
    """Compile and call each kernel once."""
    source, costs = np.zeros(1, np.uint8), np.zeros(CELLS, np.uint8)
    source.flags.writeable = False
    field, tables = np.zeros(CELLS, np.uint32), np.zeros(2 * TABLE, np.uint32)
    keys, marks, state = np.zeros(2, np.uint32), np.zeros(2, np.uint16), np.zeros(STATE_SIZE, np.int64)
    waiting, chosen, reasons = np.zeros(1, np.int32), np.zeros(BATCH, np.int32), np.zeros(BATCH, np.uint16)
    bare, reports, scratch = np.zeros(25, np.int32), np.zeros(REPORT, np.uint32), np.zeros((1, SCRATCH), np.uint32)
    cells = np.zeros(1, np.int64)
    seed_tiles(source, 1, 1, 0, field, tables, costs, 1, 1, keys, marks, waiting, bare, state, cells)
    grow_tiles(
        source, 1, 1, 0, field, tables, costs, 1, 1, keys, marks, waiting, chosen, reasons, bare, reports,
        scratch, np.zeros(1, np.int64), state, -1, 1, 1,
    )  # fmt: skip
