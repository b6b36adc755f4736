import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given

from ppaas.errors import PlanCancelled
from ppaas.planners.field import tile_field
from ppaas.planners.field.kernels import tile_groups, tile_growth, tile_layout, tile_setup, tile_walk
from ppaas.planners.field.queue_field import QueueField
from ppaas.planners.field.tile_field import PathTooLong, TileField, suits_tiles
from ppaas.planners.weights import fixed_weights
from tests.reference.planners import dijkstra as twin
from tests.support.sources import ROOT
from tests.support.world import grids
from tests.support.world.tile_fields import KINDS, drawn, fields, filled_tables


@given(grids.scenes(most=40))
def test_tiles_and_queue_give_the_same_field(scene):
    tiled, queued = fields(*scene)
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())
    assert tiled.settled == queued.settled


@given(grids.scenes(most=12))
def test_tile_field_equals_the_fixed_point_twin(scene):
    costs, goals, allow_unknown = scene
    field, _ = fields(costs, goals, allow_unknown)
    field.grow()
    values = field.values()
    units = np.where(np.isinf(values), -1, np.rint(values * 85)).astype(int)
    assert units.tolist() == twin.fixed_field(costs, goals, allow_unknown)


@pytest.mark.parametrize("kind", KINDS)
def test_early_stop_gives_the_value_and_path_of_the_queue(kind):
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


def test_field_stopped_early_can_be_grown_to_the_whole():
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


def test_only_tables_near_the_path_are_filled():
    field = TileField(grids.of(np.zeros((2_000, 2_000), np.uint8)), np.array([(1_000, 1_000)]))
    assert field.grow((1_000, 1_050))
    assert 0 < filled_tables(field) < 100


@pytest.mark.parametrize("walled", [np.s_[16:, 32:], np.s_[:16, 32:], np.s_[16:, :32], np.s_[:16, :32]])
def test_values_that_enter_beside_a_wall_propagate_along_it(walled):
    costs = np.zeros((32, 64), np.uint8)
    costs[walled] = 254
    beside = walled[1].start or walled[1].stop - 1
    tiled, queued = fields(costs, [(15 if walled[0].start else 16, beside)])
    tiled.grow()
    queued.grow()
    assert np.array_equal(tiled.values(), queued.values())


@pytest.mark.parametrize("writeable", [False, True])
def test_the_tables_of_a_read_only_map_are_filled_once(writeable):
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
        kept = filled_tables(tiled)
        del tiled
    again = TileField(map_, goals, allow_unknown=False)
    around = 3 * 2 * tile_groups.FEW
    assert filled_tables(again) <= around if writeable else filled_tables(again) == kept
    del again
    assert filled_tables(TileField(map_, goals, allow_unknown=True)) <= around < kept


def test_a_path_that_may_exceed_32_bits_is_refused():
    snake = np.full((1_216, 1_216), 252, np.uint8)
    snake[1::2] = 254
    snake[1::4, -1] = 252
    snake[3::4, 0] = 252
    field = TileField(grids.of(snake), np.array([(0, 0)]))
    with pytest.raises(PathTooLong):
        field.grow()


def test_maps_that_need_much_padding_do_not_suit_tiles():
    assert all(suits_tiles(shape) for shape in ((1, 1), (1, 40), (200, 200), (33, 60), (512, 500), (4_096, 4_096)))
    assert not any(suits_tiles(shape) for shape in ((1, 32_768), (32_768, 3), (36, 4_096)))


@pytest.mark.parametrize(("every", "winding"), [(4, False), (12, True)])
def test_corridors_that_rarely_fork_are_distinguished_from_mazes(every, winding):
    cells = np.full((401, 401), 254, np.uint8)
    cells[::2], cells[:, ::every] = 0, 0
    assert TileField(grids.of(cells), np.array([(0, 0)])).is_winding == winding


@pytest.mark.parametrize(("every", "winding"), [(4, False), (20, True)])
def test_an_undecided_first_sample_is_followed_by_a_larger_one(every, winding):
    cells = np.full((1_280, 640), 254, np.uint8)
    cells[::2] = 0
    cells.reshape(40, 32, 20, 32)[:, 1::2, ::every, ::4] = 0  # half of the sampled tiles have forks
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
    """Run the program in another process."""
    command = [sys.executable, "-c", PRINT_FIELD]
    variables = os.environ | environment | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, check=True, cwd=ROOT, env=variables, capture_output=True, text=True)
    return done.stdout.split()


def test_cached_kernels_load_without_compiler_and_any_cpu_agrees():
    for module in (tile_setup, tile_growth, tile_walk):
        module.warm()
    here, compiler_loaded = printed()
    assert compiler_loaded == "False"
    assert printed(NUMBA_CPU_NAME="generic", NUMBA_CPU_FEATURES="")[0] == here
