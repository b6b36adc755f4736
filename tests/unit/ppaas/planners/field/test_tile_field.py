import os
import subprocess
import sys
import weakref
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import PlanCancelled
from ppaas.planners.field import tile_field, tile_memory
from ppaas.planners.field.kernels import tile_groups, tile_growth, tile_layout, tile_setup, tile_visit, tile_walk
from ppaas.planners.field.kernels.tile_growth import OUT_OF_WORK, grow_tiles
from ppaas.planners.field.kernels.tile_help import BOX, FIELD_RECORD
from ppaas.planners.field.kernels.tile_state import APART, CALLED, LINES, THREADS
from ppaas.planners.field.queue_field import QueueField
from ppaas.planners.field.tile_field import PathTooLong, TileField, suits_tiles
from ppaas.planners.field.tile_helpers import boxes_for
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED
from ppaas.planners.weights import fixed_weights
from tests.reference.planners import dijkstra as twin
from tests.support.sources import ROOT
from tests.support.world import grids

MANY = 8
NOBODY = np.zeros((0, BOX), np.int64)
KINDS = ["empty", "graded", "cluttered", "patches", "maze"]


def drawn(kind, shape, seed):
    """Draw a map of which tiles are of all kinds."""
    rng = np.random.default_rng(seed)
    costs = np.zeros(shape, np.uint8)
    if kind == "graded":
        costs = rng.integers(0, 256, shape).astype(np.uint8)
    if kind == "patches":
        patches = rng.choice([0, 0, 7, 200, 252, 254, 255], (shape[0] // 24 + 1, shape[1] // 40 + 1))
        costs = np.kron(patches, np.ones((24, 40)))[: shape[0], : shape[1]].astype(np.uint8)
    if kind == "cluttered":
        costs[rng.random(shape) < 0.05 * (1 + seed % 8)] = 254
    if kind == "maze":
        costs[1::2, 1::2] = 254
        to_east = rng.random(costs[::2, ::2].shape) < 0.5
        costs[::2, 1::2][to_east[:, : costs[::2, 1::2].shape[1]]] = 254
        costs[1::2, ::2][~to_east[: costs[1::2, ::2].shape[0]]] = 254
    return costs


def fields(costs, goals, allow_unknown=True, threads=1):
    goals = np.array(goals)
    tiled = TileField(grids.of(costs), goals, allow_unknown=allow_unknown, threads=threads)
    return tiled, QueueField(grids.of(costs), goals, allow_unknown=allow_unknown)


@given(grids.scenes(most=40))
@settings(deadline=None, max_examples=60)
def test_tiles_and_queue_give_the_same_field(scene):
    tiled, queued = fields(*scene)
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())
    assert tiled.settled == queued.settled


@given(grids.scenes(most=12))
@settings(deadline=None, max_examples=60)
def test_tiles_give_the_field_of_the_naive_twin_unit_for_unit(scene):
    costs, goals, allow_unknown = scene
    field, _ = fields(costs, goals, allow_unknown)
    field.grow()
    values = field.values()
    units = np.where(np.isinf(values), -1, np.rint(values * 85)).astype(int)
    assert units.tolist() == twin.fixed_field(costs, goals, allow_unknown)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(6))
def test_any_number_of_threads_gives_the_field_of_the_queue_bit_for_bit(kind, seed, monkeypatch):
    monkeypatch.setattr(tile_field, "SLICE_ALONE_OF_FEW", 1)
    shape = [(400, 333), (64, 512), (257, 300), (480, 200), (97, 1_000), (320, 320)][seed]
    costs = drawn(kind, shape, seed)
    free = grids.free_cells(costs, seed % 2 == 0)
    goals = free[:: len(free) // (seed + 1)]
    for threads in (1, 2, 3):
        tiled, queued = fields(costs, goals, seed % 2 == 0, threads)
        tiled.grow()
        queued.grow()
        assert np.array_equal(tiled.values(), queued.values())


@pytest.fixture(scope="module")
def halls():
    """A map so large that the values of open tiles are kept until the next is worked on; nobody can write to it."""
    blocks = np.random.default_rng(3).choice([0, 0, 0, 0, 0, 0, 7, 254], (12, 12))
    costs = np.kron(blocks, np.ones((128, 128))).astype(np.uint8)
    assert costs.size >= tile_visit.STREAMED * tile_layout.CELLS
    costs.flags.writeable = False
    return costs, grids.free_cells(costs, True)


@pytest.mark.parametrize("threads", [1, 2])
def test_open_tiles_of_a_large_map_that_are_written_past_the_caches_have_the_values_of_the_queue(threads, halls):
    costs, free = halls
    tiled, queued = fields(costs, [free[len(free) // 3], free[-1]], threads=threads)
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())


@pytest.mark.parametrize("threads", [1, 2])
def test_an_early_stop_in_an_open_tile_of_a_large_map_does_not_look_at_values_of_the_field_before(threads, halls):
    costs, free = halls
    queued = fields(costs, [free[0]])[1]
    queued.grow()
    values = queued.values()
    for target in free[1 :: len(free) // 9]:
        before, _ = fields(costs, [target])  # all of its values near the target are less
        before.grow()
        used = before._memory
        del before
        tiled, _ = fields(costs, [free[0]], threads=threads)
        assert tiled._memory is used
        assert tiled.grow(target) == np.isfinite(values[target])
        if np.isfinite(values[target]):
            assert tiled.values_at(np.array([target]))[0] == values[target]
            assert tiled.path_from(target).tolist() == queued.path_from(target).tolist()


@pytest.mark.parametrize("budget", [1, 50, 3_000])
def test_threads_of_a_large_map_that_are_stopped_anywhere_leave_all_values_in_the_field(budget, halls):
    costs, free = halls
    tiled, queued = fields(costs, free[:1], threads=MANY)
    work = worker(tiled)
    for _ in range(30):
        with ThreadPoolExecutor(MANY) as threads:
            list(threads.map(work, range(MANY), [budget] * MANY))
    touched = np.flatnonzero(tiled._memory.marks[: tiled._tiles] & tile_layout.TOUCHED)
    queued.grow()
    expected, now = queued.values(), tiled.values()
    assert len(touched)
    assert (now >= expected).all()
    tiled.grow()
    assert np.array_equal(tiled.values(), expected)


@pytest.mark.parametrize("kind", KINDS)
def test_an_early_stop_leaves_the_value_and_the_path_of_the_queue(kind):
    costs = drawn(kind, (300, 270), 2)
    free = grids.free_cells(costs, True)
    goal, rng = free[len(free) // 3], np.random.default_rng(1)
    whole = fields(costs, [goal])[1]
    whole.grow()
    values = whole.values()
    for place in rng.integers(len(free), size=8):
        target = free[place]
        counts = set()
        for threads in (1, 2):
            tiled, _ = fields(costs, [goal], threads=threads)
            assert tiled.grow(target) == np.isfinite(values[target])
            if np.isfinite(values[target]):
                assert tiled.values_at(np.array([target]))[0] == values[target]
                assert tiled.path_from(target).tolist() == whole.path_from(target).tolist()
                assert tiled.settled == (values <= values[target]).sum()
            counts.add(tiled.settled)
        assert len(counts) == 1


def test_a_field_that_stopped_early_grows_on_to_the_whole():
    costs = drawn("patches", (200, 300), 5)
    free = grids.free_cells(costs, True)
    tiled, queued = fields(costs, free[:1])
    for target in free[:: len(free) // 7]:
        tiled.grow(target)
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())


def test_slices_of_any_size_give_the_same_field(monkeypatch):
    costs = drawn("cluttered", (200, 170), 5)
    goals = grids.free_cells(costs, True)[:1]
    whole, _ = fields(costs, goals)
    whole.grow()
    for name in ("SLICE_ALONE_OF_FEW", "SLICE_LINES", "SLICE_READ", "SLICE_WALKED"):
        monkeypatch.setattr(tile_field, name, 1)
    sliced, _ = fields(costs, goals, threads=2)
    sliced.grow()
    far = grids.free_cells(costs, True)[-1]
    assert np.array_equal(sliced.values(), whole.values())
    assert np.array_equal(sliced.path_from(far), whole.path_from(far))


def test_the_check_is_called_between_slices_and_ends_the_work(monkeypatch):
    for name in ("SLICE_ALONE_OF_FEW", "SLICE_LINES"):
        monkeypatch.setattr(tile_field, name, 1)
    calls = 0

    def check():
        nonlocal calls
        calls += 1
        if calls == 5:
            raise PlanCancelled("enough")

    field = TileField(grids.of(np.zeros((500, 500), np.uint8)), np.array([(250, 250)]), check=check)
    with pytest.raises(PlanCancelled):
        field.grow()
    assert calls == 5


def test_the_memory_of_a_field_that_is_gone_is_taken_over_and_nothing_is_left_in_it():
    costs = drawn("cluttered", (300, 300), 3)
    costs.flags.writeable = False
    first, _ = fields(costs, grids.free_cells(costs, True)[:1])
    first.grow()
    used = first._memory
    del first
    other = drawn("patches", (200, 290), 4)
    goals = grids.free_cells(other, False)[-1:]
    tiled, queued = fields(other, goals, allow_unknown=False, threads=2)
    assert tiled._memory is used
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())


def test_the_memory_of_a_field_on_a_map_that_may_change_is_given_back():
    costs = drawn("cluttered", (300, 300), 3)
    field, _ = fields(costs, grids.free_cells(costs, True)[:1])
    used = weakref.ref(field._memory)
    del field
    assert used() is None


def test_only_what_is_near_the_way_is_laid_out():
    field = TileField(grids.of(np.zeros((2_000, 2_000), np.uint8)), np.array([(1_000, 1_000)]))
    assert field.grow((1_000, 1_050))
    assert 0 < laid(field) < 100


@given(grids.scenes(most=100), st.integers(1, 60))
@settings(deadline=None, max_examples=40)
def test_many_threads_that_come_and_go_on_a_tiny_map_give_the_same_field(scene, budget):
    costs, goals, allow_unknown = scene
    tiled, queued = fields(costs, goals, allow_unknown, threads=MANY)
    work = worker(tiled)

    def help_along(number):
        while (outcome := work(number, budget)) in (PAUSED, OUT_OF_WORK):
            pass
        return outcome

    with ThreadPoolExecutor(MANY) as threads:
        outcomes = set(threads.map(help_along, range(MANY)))
    queued.grow()
    assert outcomes == {EXHAUSTED}
    assert np.array_equal(tiled.values(), queued.values())


@pytest.mark.parametrize("seed", range(20))
def test_threads_that_are_stopped_anywhere_leave_a_field_that_grows_on(seed):
    costs = drawn(KINDS[seed % len(KINDS)], (200, 200), seed)
    goals = grids.free_cells(costs, True)[:1]
    tiled, queued = fields(costs, goals, threads=MANY)
    work = worker(tiled)
    for stop in (10, 100, 1_000):
        with ThreadPoolExecutor(MANY) as threads:
            list(threads.map(work, range(MANY), [stop] * MANY))
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_any_number_of_threads_counts_the_same_cells(threads, monkeypatch):
    monkeypatch.setattr(tile_field, "SLICE_READ", 1)
    costs = drawn("cluttered", (330, 290), 4)
    free = grids.free_cells(costs, True)
    tiled, queued = fields(costs, free[:1], threads=threads)
    for target in (free[len(free) // 2], None):
        tiled.grow(target)
        queued.grow()
        bound = np.inf if target is None else queued.values()[tuple(target)]
        reached = queued.values()[np.isfinite(queued.values())]
        assert tiled.settled == np.count_nonzero(reached <= bound)


def test_the_check_ends_the_counting_of_all_threads(monkeypatch):
    calls = []

    def check():
        calls.append(1)
        if counting:
            raise PlanCancelled("enough")

    counting = False
    field = TileField(grids.of(np.zeros((300, 300), np.uint8)), np.array([(0, 0)]), threads=3, check=check)
    field.grow()
    monkeypatch.setattr(tile_field, "SLICE_READ", 1)
    counting = True
    before = len(calls)
    with pytest.raises(PlanCancelled):
        _ = field.settled
    assert len(calls) == before + 1


def worker(field):
    """Return the kernel for all of a field, with nobody to call: it takes the number of a thread and its budget."""
    field._memory.open_for_help(-1)
    return partial(grow_tiles, field._memory.record, NOBODY)


def helps(number, field):
    """Whether the helper of some number was called to a field."""
    return boxes_for(number + 1)[number - 1, FIELD_RECORD] == field._memory.record.ctypes.data


def test_helpers_are_called_and_the_next_field_waits_until_they_have_left():
    costs = drawn("cluttered", (600, 600), 3)
    costs.flags.writeable = False
    goals = grids.free_cells(costs, True)[:1]
    queued = QueueField(grids.of(costs), np.array(goals))
    queued.grow()
    expected = queued.values()
    called = 0
    for _ in range(10):
        tiled = TileField(grids.of(costs), np.array(goals), threads=3)
        boxes_for(2)[0, FIELD_RECORD] = 0
        tiled.grow()
        assert np.array_equal(tiled.values(), expected)
        called += helps(1, tiled)  # or the other one, if it has not quite left the field before
        del tiled
    assert called


def test_many_fields_at_a_time_share_the_helpers():
    costs = drawn("patches", (600, 600), 3)
    goals = grids.free_cells(costs, True)
    queued = [QueueField(grids.of(costs), np.array([goal])) for goal in (goals[0], goals[-1])]
    for field in queued:
        field.grow()
    expected = [field.values() for field in queued]

    def is_right(number):
        tiled = TileField(grids.of(costs), np.array([goals[-(number % 2)]]), threads=1 + number % 3)
        tiled.grow()
        return np.array_equal(tiled.values(), expected[number % 2])

    with ThreadPoolExecutor(4) as threads:
        assert all(threads.map(is_right, range(60)))


def test_the_next_field_waits_for_a_helper_who_has_not_left():
    field, _ = fields(np.zeros((64, 64), np.uint8), [(0, 0)], threads=2)
    memory, called = field._memory, THREADS + APART + CALLED
    memory.close_for_help(boxes_for(2))
    memory.state[called] = 1
    with ThreadPoolExecutor(1) as threads:
        begun = threads.submit(memory.open_for_help, -1)
        with pytest.raises(TimeoutError):
            begun.result(0.05)
        memory.state[called] = 0
        begun.result(30)


@pytest.mark.parametrize("writeable", [False, True])
def test_what_a_helper_still_uses_is_kept_until_it_has_left(writeable):
    costs = np.zeros((64, 64), np.uint8)
    costs.flags.writeable = writeable
    field, _ = fields(costs, [(0, 0)], threads=2)
    memory, source = weakref.ref(field._memory), weakref.ref(field._source)
    state = field._memory.state
    field._memory.close_for_help(boxes_for(2))
    state[THREADS + APART + CALLED] = 1
    del field
    assert memory() is not None
    assert source() is not None
    state[THREADS + APART + CALLED] = 0
    other, _ = fields(np.zeros((100, 100), np.uint8), [(0, 0)])
    del other
    assert memory() is None
    assert source() is None


def test_a_helper_who_finds_all_done_leaves():
    tiled, _ = fields(np.zeros((64, 64), np.uint8), [(0, 0)], threads=2)
    work = worker(tiled)
    assert work(0, 1_000_000) == EXHAUSTED
    assert work(1, 1_000_000) == EXHAUSTED


@pytest.mark.parametrize(("size", "asked"), [(500, False), (600, True)])
def test_on_a_small_map_one_thread_goes_farther_before_it_asks_for_others(size, asked):
    tiled = TileField(grids.of(np.zeros((size, size), np.uint8)), np.array([(250, 250)]), threads=2)
    boxes_for(2)[0, FIELD_RECORD] = 0  # the record of a field that is gone may have lain at the same address
    assert tiled.grow((250, 480))
    assert helps(1, tiled) == asked


@pytest.mark.parametrize(
    ("size", "target", "at_once"), [(300, None, False), (420, None, True), (600, None, True), (600, (250, 480), False)]
)
def test_others_are_asked_for_at_once_where_all_of_a_map_is_to_be_reached(size, target, at_once, monkeypatch):
    asked = []

    def boxes(threads):
        asked.extend([tiled._memory.state[THREADS + LINES]] * (threads - 1))
        return boxes_for(threads)

    monkeypatch.setattr(tile_field, "boxes_for", boxes)
    tiled = TileField(grids.of(np.zeros((size, size), np.uint8)), np.array([(250, 250)]), threads=2)
    assert tiled.grow(target)
    assert (asked[:1] == [0]) == at_once


@pytest.mark.parametrize("walled", [np.s_[16:, 32:], np.s_[:16, 32:], np.s_[16:, :32], np.s_[:16, :32]])
def test_what_comes_from_beside_a_wall_goes_on_along_the_wall(walled):
    costs = np.zeros((32, 64), np.uint8)
    costs[walled] = 254
    beside = walled[1].start or walled[1].stop - 1
    tiled, queued = fields(costs, [(15 if walled[0].start else 16, beside)])
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())


def laid(field):
    return np.count_nonzero(field._memory.marks[: field._tiles] & tile_layout.LAID)


@pytest.mark.parametrize("writeable", [False, True])
def test_a_map_that_nobody_can_write_to_is_laid_out_once(writeable):
    costs = drawn("patches", (200, 290), 4)
    costs.flags.writeable = writeable
    free = grids.free_cells(costs, False)
    map_, goals = grids.of(costs), np.array(free[-1:])
    for goal in (goals, np.array(free[:1]), goals):
        tiled, queued = TileField(map_, goal, allow_unknown=False), QueueField(map_, goal, allow_unknown=False)
        tiled.grow(None if goal is goals else free[40])
        queued.grow(None if goal is goals else free[40])
        assert tiled.settled == queued.settled
        if goal is goals:
            assert np.array_equal(tiled.values(), queued.values())
        kept = laid(tiled)
        del tiled
    again = TileField(map_, goals, allow_unknown=False)
    around = 3 * 2 * tile_groups.FEW
    assert laid(again) <= around if writeable else laid(again) == kept
    del again
    assert laid(TileField(map_, goals, allow_unknown=True)) <= around < kept


FIELDS_AT_THE_END = """
from tests.support.world import grids
from ppaas.planners.field.tile_field import TileField
import numpy as np
fields = [TileField(grids.of(np.zeros((500, 500), np.uint8)), np.array([(9, 9)]), threads=2) for _ in range(3)]
for field in fields:
    field.grow()
fields[0].itself = fields[0]
"""


def test_a_process_ends_in_peace_that_still_holds_fields():
    done = subprocess.run(
        [sys.executable, "-c", FIELDS_AT_THE_END], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert done.stderr == ""


def test_memory_that_is_far_too_large_is_let_go():
    tile_memory.give_back(tile_memory.TileMemory(100), np.zeros(1, np.uint8))
    assert tile_memory.take(20).tiles == 20
    assert not tile_memory._spare


def test_memory_of_a_larger_map_deals_out_the_tiles_of_this_one():
    map_ = grids.of(np.zeros((64, 64), np.uint8))
    source = map_.data.reshape(-1)
    fitting, larger = tile_memory.TileMemory(500), tile_memory.TileMemory(1_500)
    for memory in (fitting, larger):
        memory.begin(source, (20, 25), 2, map_, allow_unknown=True)
    assert (fitting.places == larger.places).all()
    assert len(fitting.words) == len(larger.words) == 512
    larger.begin(source, (60, 25), 2, map_, allow_unknown=True)
    assert len(larger.words) == 1_536


def test_at_most_six_bytes_a_cell_are_used():
    memory = tile_memory.TileMemory(64 * 64)
    arrays = (memory.field, memory.tables, memory.costs, memory.marks, memory.words, memory.hints, memory.places)
    assert sum(array.nbytes for array in arrays) <= 6 * 2_048**2


def test_a_way_that_may_be_too_long_is_refused():
    snake = np.full((1_216, 1_216), 252, np.uint8)
    snake[1::2] = 254
    snake[1::4, -1] = 252
    snake[3::4, 0] = 252
    field = TileField(grids.of(snake), np.array([(0, 0)]))
    with pytest.raises(PathTooLong):
        field.grow()


def test_maps_that_would_mostly_be_padding_do_not_suit():
    assert all(suits_tiles(shape) for shape in ((1, 1), (1, 40), (200, 200), (33, 60), (512, 500), (4_096, 4_096)))
    assert not any(suits_tiles(shape) for shape in ((1, 32_768), (32_768, 3), (36, 4_096)))


@pytest.mark.parametrize(("every", "winding"), [(4, False), (12, True)])
def test_corridors_that_seldom_fork_are_told_from_mazes(every, winding):
    cells = np.full((401, 401), 254, np.uint8)
    cells[::2], cells[:, ::every] = 0, 0
    assert TileField(grids.of(cells), np.array([(0, 0)])).is_winding == winding


@pytest.mark.parametrize(("every", "winding"), [(4, False), (20, True)])
def test_where_a_first_look_leaves_it_open_more_of_the_map_tells_how_often_corridors_fork(every, winding):
    cells = np.full((1_280, 640), 254, np.uint8)
    cells[::2] = 0
    cells.reshape(40, 32, 20, 32)[:, 1::2, ::every, ::4] = 0  # half of the tiles that one look tells of have forks
    assert TileField(grids.of(cells), np.array([(0, 0)])).is_winding == winding


def test_the_formula_of_the_weights_is_their_table():
    cardinal, diagonal = fixed_weights()
    for cost in [*range(253), 255]:
        weight = tile_layout.BASE + tile_layout.FACTOR * cost if cost < 255 else tile_layout.UNKNOWN
        assert weight == cardinal[cost]
        assert (weight * tile_layout.ROOT + tile_layout.HALF) >> tile_layout.ROOT_SHIFT == diagonal[cost]


PRINT_FIELD = """
import sys, zlib
import numpy as np
from engine.runtimes.compilation import threading_layer
threading_layer.choose()
from engine.runtimes.memory_tuning import cached_kernels
cached_kernels.load_without_compiler()
from ppaas.planners.field.tile_field import TileField
from tests.support.world import grids
rng = np.random.default_rng(4)
costs = rng.integers(0, 256, (150, 140)).astype(np.uint8)
costs[:64, :64] = 9
field = TileField(grids.of(costs), np.array([(3, 3)]), threads=2)
field.grow()
print(zlib.crc32(field.values().tobytes()), "numba.np.npyimpl" in sys.modules)
"""


def printed(**environment):
    """Run that in a process of its own."""
    command = [sys.executable, "-c", PRINT_FIELD]
    variables = os.environ | environment | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, check=True, cwd=ROOT, env=variables, capture_output=True, text=True)
    return done.stdout.split()


def test_kernels_in_the_cache_are_loaded_without_the_compiler_and_any_cpu_gives_the_same_field():
    for module in (tile_setup, tile_growth, tile_walk):
        module.warm()
    here, compiler_loaded = printed()
    assert compiler_loaded == "False"
    assert printed(NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="")[0] == here
