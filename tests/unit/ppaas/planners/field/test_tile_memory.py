import gc
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ppaas.planners.field import tile_memory
from ppaas.planners.field.kernels.tile_state import APART, CALLED, THREADS
from ppaas.planners.field.tile_helpers import boxes_for
from tests.support.world import grids
from tests.support.world.tile_fields import drawn, fields


def test_memory_of_a_deleted_field_is_reused_without_old_values():
    gc.collect()  # a field of another test that is deleted later would take the place of this memory
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


def test_the_memory_of_a_field_on_a_writable_map_is_freed():
    costs = drawn("cluttered", (300, 300), 3)
    field, _ = fields(costs, grids.free_cells(costs, True)[:1])
    used = weakref.ref(field._memory)
    del field
    assert used() is None


def test_next_field_waits_for_a_helper_that_has_not_left():
    field, _ = fields(np.zeros((64, 64), np.uint8), [(0, 0)], threads=2)
    memory, called = field._memory, THREADS + APART + CALLED
    memory.close_for_help(boxes_for(2))
    memory.state[called] = 1
    with ThreadPoolExecutor(1) as threads:
        opening = threads.submit(memory.open_for_help, -1)
        with pytest.raises(TimeoutError):
            opening.result(0.05)
        memory.state[called] = 0
        opening.result(30)


@pytest.mark.parametrize("writeable", [False, True])
def test_arrays_that_a_helper_still_uses_are_kept_until_it_has_left(writeable):
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


def test_memory_that_is_far_too_large_is_freed():
    tile_memory.release(tile_memory.TileMemory(100), np.zeros(1, np.uint8))
    assert tile_memory.acquire(20).tiles == 20
    assert not tile_memory._spare


def test_memory_of_a_larger_map_assigns_the_tiles_of_this_one():
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
