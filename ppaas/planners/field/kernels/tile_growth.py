"""Kernel: grow a field of costs from its goals outward, tile by tile, on as many threads as call it.

Tiles wait with the least value that a neighbour would better in them. Each thread takes the one with the least, works
on it until nothing changes within it, and wakes the neighbours in which it would better something. As values are whole
numbers that only fall, and nobody stops before none can fall, the field is the same whoever comes first.

No thread waits for another as long as there is work. One that is put aside in the middle of a tile holds up that
tile, and perhaps the one before, whose values it had yet to put down.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.field.kernels.propagation import TOO_NARROW
from ppaas.planners.field.kernels.tile_groups import lay_around
from ppaas.planners.field.kernels.tile_help import BOX, call_one
from ppaas.planners.field.kernels.tile_layout import (
    CELL_SHIFT,
    CELLS,
    EDGES,
    FREE,
    GOAL,
    KIND,
    LAID,
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
    lay_places,
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
    note,
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
from ppaas.planners.field.kernels.tile_visit import put_down, visit
from ppaas.planners.kernels import atomics
from ppaas.planners.kernels.addresses import longs_of, map_of, numbers_of, octets_of
from ppaas.planners.kernels.jit_decorators import bare
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED, SETTLED

Int = int | np.signedinteger[Any]
Ints = NDArray[np.int64]
Numbers = NDArray[np.uint32]
Bytes = NDArray[np.uint8]

OUT_OF_WORK = 5
"""Others may find some, but for a while they did not."""

SOON = 8_000
"""Lines of tiles after which a search is not expected to end soon any more: a tenth of a millisecond."""
PER_VISIT = 40
"""Lines that the work around a visit is worth."""
POLLS = 500
"""Looks for work before a thread gives up: some 20 µs."""
EACH = 3
"""So many tiles must wait for each thread before one more is asked for."""


@bare
def _clear(record: Ints, knows: bool) -> None:
    """Make the arrays those of a field in which nobody has been."""
    tiles = record[TILES]
    tables, marks, state = numbers_of(record, TABLES), octets_of(record, MARKS), longs_of(record, STATE)
    words, hints = numbers_of(record, WORDS), numbers_of(record, HINTS)
    for tile in range(tiles):
        marks[tile] = marks[tile] & LAID if knows else 0
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
    marks[tiles] = LAID


@bare
def seed_tiles(record: Ints, knows: bool, goals: Ints) -> None:
    """Begin a field: put the goals into it.

    Parameters
    ----------
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`; nobody else uses it or its arrays.
    knows : bool
        Whether tables that are marked as filled are those of this map.
    goals : (n, 2) int64 array
        Row, column; one may be named twice.
    """
    _clear(record, knows)
    source, height, width, unknown = map_of(record, SOURCE), record[HEIGHT], record[WIDTH], record[UNKNOWN]
    across, tiles, state = record[ACROSS], record[TILES], longs_of(record, STATE)
    field, tables, costs = numbers_of(record, FIELD), numbers_of(record, TABLES), octets_of(record, COSTS)
    marks, words = octets_of(record, MARKS), numbers_of(record, WORDS)
    hints, places = numbers_of(record, HINTS), numbers_of(record, PLACES)
    scratch = numbers_of(record, SCRATCH_MEMORY)
    for goal in range(len(goals)):
        row, column = goals[goal, 0], goals[goal, 1]
        tile = row // SIDE * across + column // SIDE
        if not marks[tile] & TOUCHED:
            lay_around(source, height, width, unknown, across, tiles, tile, costs, tables, marks, scratch, False)
            for inner in range(CELLS):
                field[tile * CELLS + inner] = UNREACHED
            for place in range(FREE):
                tables[tile * TABLE + place] = UNREACHED
            marks[tile] |= TOUCHED
            state[THREADS + WAITING] += wake(words, hints, places, tile, np.int64(0), np.int64(GOAL))
        field[tile * CELLS + row % SIDE * SIDE + column % SIDE] = 0


@bare
def _bound_of(target: Int, field: Numbers, marks: Bytes) -> Int:
    """Return the least word with which a tile that waits can no longer better the target."""
    if target < 0 or not atomics.read(marks, target >> CELL_SHIFT) & TOUCHED:
        return IDLE
    value: Int = atomics.read(field, target)
    return min(((value >> UNIT_SHIFT) + 1) << KEY_SHIFT, IDLE)


@bare
def _find_work(hints: Numbers, state: Ints, bound: Int) -> Int:
    """Look for a tile that waits, as one that will wake none; return PAUSED if one does, else why there is none."""
    atomics.add(state, ACTIVE, -1)
    outcome: Int = OUT_OF_WORK
    for _ in range(POLLS):
        # All that wake tiles are through: what they woke can be seen, and will not become more.
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
def _give_up(field: Numbers, tiles: Int, words: Numbers, hints: Numbers, places: Numbers, scratch: Numbers) -> Int:
    """Put down what is kept of a tile, and end the work on it; return whether it waits again."""
    kept = np.int64(scratch[KEPT])
    put_down(field, tiles, scratch)
    return np.int64(let_go(words, hints, places, kept)) if kept != tiles else np.int64(0)


@bare
def _is_short_of_hands(state: Ints, helpers: Int) -> bool:
    """Return whether not all helpers are called, and so many tiles wait that one more is worth it."""
    waiting, called = state[THREADS + WAITING], 0
    for helper in range(1, helpers + 1):
        called += state[THREADS + helper * APART + CALLED]
    if called == helpers:  # before a look at what they write all the time
        return False
    for helper in range(1, helpers + 1):
        waiting += state[THREADS + helper * APART + WAITING]
    return bool(waiting >= EACH * (called + 1))


@bare
def grow_tiles(record: Ints, boxes: Ints, thread: int, budget: int) -> int:
    """Work until ``budget`` lines of tiles are done, and tell why it stopped.

    Parameters
    ----------
    record : (RECORD,) int64 array
        As in `ppaas.planners.field.kernels.tile_record`.
    boxes : (n, BOX) int64 array
        Of the helpers that may be called, as in `ppaas.planners.field.kernels.tile_help`; none if this is one itself.
    thread : int
        Which of the threads this is.
    budget : int
        Lines to do before it pauses, give or take a tile.

    Returns
    -------
    int
        EXHAUSTED, SETTLED, PAUSED or TOO_NARROW, as in `ppaas.planners.field.kernels.propagation`, or OUT_OF_WORK.
    """
    source, height, width, unknown = map_of(record, SOURCE), record[HEIGHT], record[WIDTH], record[UNKNOWN]
    across, tiles, target, state = record[ACROSS], record[TILES], record[TARGET], longs_of(record, STATE)
    field, tables, costs = numbers_of(record, FIELD), numbers_of(record, TABLES), octets_of(record, COSTS)
    marks, words = octets_of(record, MARKS), numbers_of(record, WORDS)
    hints, places = numbers_of(record, HINTS), numbers_of(record, PLACES)
    scratch = numbers_of(record, SCRATCH_MEMORY)
    me = THREADS + thread * APART
    threads = len(scratch) // SCRATCH
    part = len(hints) // threads
    hands = min(len(boxes), threads - 1)
    own: Int = 0
    end = state[me + LINES] + budget
    outcome = PAUSED
    mine = scratch[thread * SCRATCH : (thread + 1) * SCRATCH]
    mine[KEPT] = tiles
    atomics.add(state, ACTIVE, 1)
    while outcome == PAUSED and state[me + LINES] < end and not atomics.read(state, STOP):
        bound = _bound_of(target, field, marks)
        # Who is alone has all tiles.
        begin, count = (thread * part, part) if atomics.read(state, ACTIVE) > 1 else (0, len(hints))
        tile, word = take(words, hints, places, bound, begin, count, own <= 0)
        if tile == NONE:
            state[me + WAITING] += _give_up(field, tiles, words, hints, places, mine)
            outcome = _find_work(hints, state, bound)
            continue
        own = until_look(own, places[tile // GROUP] // part == thread)
        if not marks[tile] & TOUCHED:
            is_far = target < 0 or state[me + LINES] >= SOON
            lay_around(source, height, width, unknown, across, tiles, tile, costs, tables, marks, mine, is_far)
        kept = np.int64(mine[KEPT])
        woken, work, overlong = visit(
            field, tables, costs, across, tiles, tile, word & REASONS, marks, words, hints, places, mine,
            tile != target >> CELL_SHIFT,
        )  # fmt: skip
        for done in (kept, tile):
            if done != tiles and done != mine[KEPT]:
                woken += let_go(words, hints, places, done)
        state[me + WAITING] += woken - 1
        state[me + LINES] += work + PER_VISIT
        if overlong:
            atomics.write(state, OVERLONG, 1)
        if atomics.read(state, OVERLONG):
            outcome = TOO_NARROW
        elif hands and _is_short_of_hands(state, hands) and not call_one(boxes, record):
            hands = 0
    state[me + WAITING] += _give_up(field, tiles, words, hints, places, mine)
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
    lay_places(places, 1, 1)
    record = np.zeros(RECORD, np.int64)
    record[[HEIGHT, WIDTH, ACROSS, TILES, TARGET]] = 1, 1, 1, 1, -1
    for place, array in (
        (SOURCE, source), (FIELD, field), (TABLES, tables), (COSTS, costs), (MARKS, marks), (WORDS, words),
        (HINTS, hints), (PLACES, places), (SCRATCH_MEMORY, scratch), (STATE, state),
    ):  # fmt: skip
        note(record, place, array)
    seed_tiles(record, knows=False, goals=np.zeros((1, 2), np.int64))
    grow_tiles(record, np.zeros((0, BOX), np.int64), 0, 1)
