"""Kernel: grow a cost field from its goals outward, tile by tile, on all threads that call it.

A queued tile has as its key the least value that a neighbour would improve in it. Each thread takes the tile with the
least key, relaxes it until nothing changes within it, and queues the neighbours in which it improves a value. Values
are integers that only decrease, and the threads stop when none can, so the field does not depend on their order.

No thread waits for another as long as there is work. A thread that is preempted within a tile delays that tile, and
perhaps the previous one, whose values it has not written back yet.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.kernel_cache.decorators import bare
from ppaas.planners.field.kernels.propagation import TOO_NARROW
from ppaas.planners.field.kernels.tile_groups import fill_around
from ppaas.planners.field.kernels.tile_help import BOX, call_one
from ppaas.planners.field.kernels.tile_layout import (
    CELL_SHIFT,
    CELLS,
    EDGES,
    FILLED,
    FREE,
    GOAL,
    KIND,
    SIDE,
    TABLE,
    TOUCHED,
    UNREACHED,
)
from ppaas.planners.field.kernels.tile_queue import (
    GROUP,
    IDLE,
    KEY_SHIFT,
    NONE,
    REASONS,
    UNIT_SHIFT,
    deal_groups,
    let_go,
    part_size,
    take,
    until_look,
    waits,
    wake,
)
from ppaas.planners.field.kernels.tile_record import (
    ACROSS,
    COSTS,
    FIELD,
    HEIGHT,
    HINTS,
    MARKS,
    PLACES,
    RECORD,
    SCRATCH_MEMORY,
    SOURCE,
    STATE,
    TABLES,
    TARGET,
    TILES,
    UNKNOWN,
    WIDTH,
    WORDS,
    store_array,
)
from ppaas.planners.field.kernels.tile_rows import KEPT, SCRATCH
from ppaas.planners.field.kernels.tile_state import (
    ACTIVE,
    APART,
    CALLED,
    LINES,
    OVERLONG,
    STOP,
    THREADS,
    WAITING,
    state_size,
)
from ppaas.planners.field.kernels.tile_visit import visit, write_back
from ppaas.planners.kernels import atomics
from ppaas.planners.kernels.addresses import bytes_of, int64s_of, readonly_bytes_of, uint32s_of
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED, SETTLED

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

OUT_OF_WORK = 5
"""Other threads are still working, but no tile was queued for a while: call again later."""

SOON = 8_000
"""Lines of tiles after which a search is no longer expected to end soon: 0.1 ms."""
PER_VISIT = 40
"""Overhead of a visit to a tile, in lines."""
POLLS = 500
"""Number of polls for work before a thread returns: about 20 µs."""
EACH = 3
"""Least number of queued tiles per thread before another helper is called."""


@bare
def _clear(record: Ints, knows: bool) -> None:
    """Reset the arrays to an unvisited field; filled tables are kept if ``knows``."""
    tiles = record[TILES]
    tables, marks, state = uint32s_of(record, TABLES), bytes_of(record, MARKS), int64s_of(record, STATE)
    words, hints = uint32s_of(record, WORDS), uint32s_of(record, HINTS)
    for tile in range(tiles):
        marks[tile] = marks[tile] & FILLED if knows else 0
    for place in range(len(words)):
        words[place] = IDLE
    for place in range(len(hints)):
        hints[place] = IDLE
    for place in range(len(state)):
        state[place] = 0
    outside = tiles * TABLE
    for place in range(outside + EDGES, outside + FREE):
        tables[place] = UNREACHED
    for place in range(outside + FREE, outside + KIND + 1):
        tables[place] = 0
    marks[tiles] = FILLED


@bare
def seed_tiles(record: Ints, knows: bool, goals: Ints) -> None:
    """Begin a field: reset the arrays and queue the tiles of the goals.

    Parameters
    ----------
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`; no other thread may be using it or its arrays.
    knows : bool
        Whether tables that are marked as filled are valid for this map.
    goals : (n, 2) int64 array
        Row, column; duplicates are allowed.
    """
    _clear(record, knows)
    source, height, width, unknown = readonly_bytes_of(record, SOURCE), record[HEIGHT], record[WIDTH], record[UNKNOWN]
    across, tiles, state = record[ACROSS], record[TILES], int64s_of(record, STATE)
    field, tables, costs = uint32s_of(record, FIELD), uint32s_of(record, TABLES), bytes_of(record, COSTS)
    marks, words = bytes_of(record, MARKS), uint32s_of(record, WORDS)
    hints, places = uint32s_of(record, HINTS), uint32s_of(record, PLACES)
    scratch = uint32s_of(record, SCRATCH_MEMORY)
    for goal in range(len(goals)):
        row, column = goals[goal, 0], goals[goal, 1]
        tile = row // SIDE * across + column // SIDE
        if not marks[tile] & TOUCHED:
            fill_around(source, height, width, unknown, across, tiles, tile, costs, tables, marks, scratch, False)
            for inner in range(CELLS):
                field[tile * CELLS + inner] = UNREACHED
            for place in range(FREE):
                tables[tile * TABLE + place] = UNREACHED
            marks[tile] |= TOUCHED
            state[THREADS + WAITING] += wake(words, hints, places, tile, np.int64(0), np.int64(GOAL))
        field[tile * CELLS + row % SIDE * SIDE + column % SIDE] = 0


@bare
def _bound_of(target: Int, field: Numbers, marks: Bytes) -> Int:
    """Return the least word of a queued tile that can no longer improve the target."""
    if target < 0 or not atomics.read(marks, target >> CELL_SHIFT) & TOUCHED:
        return IDLE
    value: Int = atomics.read(field, target)
    return min(((value >> UNIT_SHIFT) + 1) << KEY_SHIFT, IDLE)


@bare
def _find_work(hints: Numbers, state: Ints, bound: Int) -> Int:
    """Poll for a queued tile while not counted as active; return PAUSED if there is one, else why there is none."""
    atomics.add(state, ACTIVE, -1)
    outcome: Int = OUT_OF_WORK
    for _ in range(POLLS):
        # If no thread is active, no further tile will be queued, and all queued ones are visible.
        last = atomics.read(state, ACTIVE) == 0
        if waits(hints, bound):
            outcome = PAUSED
        elif last:
            outcome = SETTLED if waits(hints, np.int64(IDLE)) else EXHAUSTED
        if outcome != OUT_OF_WORK or atomics.read(state, STOP):
            break
    atomics.add(state, ACTIVE, 1)
    return outcome


@bare
def _end_visit(field: Numbers, tiles: Int, words: Numbers, hints: Numbers, places: Numbers, scratch: Numbers) -> Int:
    """Write back the values of the tile in scratch memory and release it; return whether it is queued again."""
    kept = np.int64(scratch[KEPT])
    write_back(field, tiles, scratch)
    return np.int64(let_go(words, hints, places, kept)) if kept != tiles else np.int64(0)


@bare
def _needs_helper(state: Ints, helpers: Int) -> bool:
    """Return whether a further helper is available, and enough tiles are queued for it."""
    waiting, called = state[THREADS + WAITING], 0
    for helper in range(1, helpers + 1):
        called += state[THREADS + helper * APART + CALLED]
    if called == helpers:  # return before reading the counters, whose cache lines the helpers write to
        return False
    for helper in range(1, helpers + 1):
        waiting += state[THREADS + helper * APART + WAITING]
    return bool(waiting >= EACH * (called + 1))


@bare
def grow_tiles(record: Ints, boxes: Ints, thread: int, budget: int) -> int:
    """Process about ``budget`` lines of tiles, and return why the kernel stopped.

    Parameters
    ----------
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`.
    boxes : (n, BOX) int64 array
        Mailboxes of the available helpers, as in `ppaas.planners.field.kernels.tile_help`; empty in a helper itself.
    thread : int
        Number of this thread; 0 is the planner's own.
    budget : int
        Number of lines to process in this call, up to a tile more.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED or TOO_NARROW, as in `ppaas.planners.field.kernels.propagation`, or OUT_OF_WORK.
    """
    source, height, width, unknown = readonly_bytes_of(record, SOURCE), record[HEIGHT], record[WIDTH], record[UNKNOWN]
    across, tiles, target, state = record[ACROSS], record[TILES], record[TARGET], int64s_of(record, STATE)
    field, tables, costs = uint32s_of(record, FIELD), uint32s_of(record, TABLES), bytes_of(record, COSTS)
    marks, words = bytes_of(record, MARKS), uint32s_of(record, WORDS)
    hints, places = uint32s_of(record, HINTS), uint32s_of(record, PLACES)
    scratch = uint32s_of(record, SCRATCH_MEMORY)
    me = THREADS + thread * APART
    threads = len(scratch) // SCRATCH
    part = len(hints) // threads
    helpers = min(len(boxes), threads - 1)
    own: Int = 0
    end = state[me + LINES] + budget
    outcome = PAUSED
    mine = scratch[thread * SCRATCH : (thread + 1) * SCRATCH]
    mine[KEPT] = tiles
    atomics.add(state, ACTIVE, 1)
    while outcome == PAUSED and state[me + LINES] < end and not atomics.read(state, STOP):
        bound = _bound_of(target, field, marks)
        # A single active thread owns all tiles; otherwise each owns its part.
        begin, count = (thread * part, part) if atomics.read(state, ACTIVE) > 1 else (0, len(hints))
        tile, word = take(words, hints, places, bound, begin, count, own <= 0)
        if tile == NONE:
            state[me + WAITING] += _end_visit(field, tiles, words, hints, places, mine)
            outcome = _find_work(hints, state, bound)
            continue
        # Visit the tile.
        own = until_look(own, places[tile // GROUP] // part == thread)
        if not marks[tile] & TOUCHED:
            is_far = target < 0 or state[me + LINES] >= SOON
            fill_around(source, height, width, unknown, across, tiles, tile, costs, tables, marks, mine, is_far)
        kept = np.int64(mine[KEPT])
        woken, work, overlong = visit(
            field, tables, costs, across, tiles, tile, word & REASONS, marks, words, hints, places, mine,
            tile != target >> CELL_SHIFT,
        )  # fmt: skip
        # Release this tile and the one before, unless their values are still in scratch memory.
        for done in (kept, tile):
            if done != tiles and done != mine[KEPT]:
                woken += let_go(words, hints, places, done)
        state[me + WAITING] += woken - 1
        state[me + LINES] += work + PER_VISIT
        if overlong:
            atomics.write(state, OVERLONG, 1)
        if atomics.read(state, OVERLONG):
            outcome = TOO_NARROW
        elif helpers and _needs_helper(state, helpers) and not call_one(boxes, record):
            helpers = 0
    state[me + WAITING] += _end_visit(field, tiles, words, hints, places, mine)
    atomics.add(state, ACTIVE, -1)
    atomics.write(state, me + CALLED, 0)
    return outcome


def warm() -> None:
    """Compile and call each kernel once."""
    source, costs, marks = np.zeros(1, np.uint8), np.zeros(CELLS, np.uint8), np.zeros(2, np.uint8)
    field, tables = np.zeros(CELLS, np.uint32), np.zeros(2 * TABLE, np.uint32)
    words, hints = np.zeros(GROUP, np.uint32), np.zeros(SIDE, np.uint32)
    places, scratch = np.zeros(1 + part_size(1, 1), np.uint32), np.zeros(SCRATCH, np.uint32)
    state = np.zeros(state_size(1), np.int64)
    deal_groups(places, 1, 1)
    record = np.zeros(RECORD, np.int64)
    record[[HEIGHT, WIDTH, ACROSS, TILES, TARGET]] = 1, 1, 1, 1, -1
    for place, array in (
        (SOURCE, source), (FIELD, field), (TABLES, tables), (COSTS, costs), (MARKS, marks), (WORDS, words),
        (HINTS, hints), (PLACES, places), (SCRATCH_MEMORY, scratch), (STATE, state),
    ):  # fmt: skip
        store_array(record, place, array)
    seed_tiles(record, knows=False, goals=np.zeros((1, 2), np.int64))
    grow_tiles(record, np.zeros((0, BOX), np.int64), 0, 1)
