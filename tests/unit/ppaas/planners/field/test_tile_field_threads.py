import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import PlanCancelled
from ppaas.planners.field import tile_field
from ppaas.planners.field.kernels import tile_layout, tile_visit
from ppaas.planners.field.kernels.tile_growth import OUT_OF_WORK
from ppaas.planners.field.kernels.tile_help import FIELD_RECORD
from ppaas.planners.field.kernels.tile_state import LINES, THREADS
from ppaas.planners.field.queue_field import QueueField
from ppaas.planners.field.tile_field import TileField
from ppaas.planners.field.tile_helpers import boxes_for
from ppaas.planners.kernels.moves import EXHAUSTED, PAUSED
from tests.support.sources import ROOT
from tests.support.world import grids
from tests.support.world.tile_fields import KINDS, MANY, drawn, fields, helps, worker


@pytest.fixture(scope="module")
def halls():
    """Return a read-only map so large that open tiles are written back during the next visit."""
    blocks = np.random.default_rng(3).choice([0, 0, 0, 0, 0, 0, 7, 254], (12, 12))
    costs = np.kron(blocks, np.ones((128, 128))).astype(np.uint8)
    assert costs.size >= tile_visit.STREAMED * tile_layout.CELLS
    costs.flags.writeable = False
    return costs, grids.free_cells(costs, True)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(6))
def test_field_is_bitwise_equal_to_the_queue_on_any_threads(kind, seed, monkeypatch):
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


@pytest.mark.parametrize("threads", [1, 2])
def test_streamed_open_tiles_of_a_large_map_have_the_values_of_the_queue(threads, halls):
    costs, free = halls
    tiled, queued = fields(costs, [free[len(free) // 3], free[-1]], threads=threads)
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())


@pytest.mark.parametrize("threads", [1, 2])
def test_early_stop_in_an_open_tile_ignores_values_of_the_last_field(threads, halls):
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
def test_stopped_threads_leave_valid_values_on_a_large_map(budget, halls):
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


@given(grids.scenes(most=100), st.integers(1, 60))
def test_threads_may_join_and_leave_on_a_tiny_map(scene, budget):
    costs, goals, allow_unknown = scene
    tiled, queued = fields(costs, goals, allow_unknown, threads=MANY)
    work = worker(tiled)

    def help_until_exhausted(number):
        while (outcome := work(number, budget)) in (PAUSED, OUT_OF_WORK):
            pass
        return outcome

    with ThreadPoolExecutor(MANY) as threads:
        outcomes = set(threads.map(help_until_exhausted, range(MANY)))
    queued.grow()
    assert outcomes == {EXHAUSTED}
    assert np.array_equal(tiled.values(), queued.values())


@pytest.mark.parametrize("seed", range(20))
def test_field_can_be_grown_after_threads_were_stopped(seed):
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


def test_many_concurrent_fields_share_the_helpers():
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


def test_a_helper_that_finds_no_work_leaves():
    tiled, _ = fields(np.zeros((64, 64), np.uint8), [(0, 0)], threads=2)
    work = worker(tiled)
    assert work(0, 1_000_000) == EXHAUSTED
    assert work(1, 1_000_000) == EXHAUSTED


@pytest.mark.parametrize(("size", "called_helpers"), [(500, False), (600, True)])
def test_helpers_are_called_later_on_a_small_map(size, called_helpers):
    tiled = TileField(grids.of(np.zeros((size, size), np.uint8)), np.array([(250, 250)]), threads=2)
    boxes_for(2)[0, FIELD_RECORD] = 0  # the record of a deleted field may have had the same address
    assert tiled.grow((250, 480))
    assert helps(1, tiled) == called_helpers


@pytest.mark.parametrize(
    ("size", "target", "at_once"), [(300, None, False), (420, None, True), (600, None, True), (600, (250, 480), False)]
)
def test_helpers_are_called_at_once_for_the_whole_of_a_large_map(size, target, at_once, monkeypatch):
    called_helpers = []

    def boxes(threads):
        called_helpers.extend([tiled._memory.state[THREADS + LINES]] * (threads - 1))
        return boxes_for(threads)

    monkeypatch.setattr(tile_field, "boxes_for", boxes)
    tiled = TileField(grids.of(np.zeros((size, size), np.uint8)), np.array([(250, 250)]), threads=2)
    assert tiled.grow(target)
    assert (called_helpers[:1] == [0]) == at_once


FIELDS_AT_THE_END = """
from tests.support.world import grids
from ppaas.planners.field.tile_field import TileField
import numpy as np
fields = [TileField(grids.of(np.zeros((500, 500), np.uint8)), np.array([(9, 9)]), threads=2) for _ in range(3)]
for field in fields:
    field.grow()
fields[0].itself = fields[0]
"""


def test_a_process_that_still_holds_fields_exits_cleanly():
    done = subprocess.run(
        [sys.executable, "-c", FIELDS_AT_THE_END], cwd=ROOT, check=True, capture_output=True, text=True
    )
    assert done.stderr == ""
