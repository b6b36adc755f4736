import numpy as np
import pytest
from hypothesis import given

from ppaas.planners.field import queue_field
from ppaas.planners.field.queue_field import QueueField
from ppaas.planners.field.tile_field import TileField
from tests.reference.planners import dijkstra as twin
from tests.support.world import grids


@given(grids.scenes())
def test_field_equals_the_fixed_point_twin(scene):
    costs, goals, allow_unknown = scene
    field = QueueField(grids.of(costs), np.array(goals), allow_unknown=allow_unknown)
    field.grow()
    values = field.values()
    units = np.where(np.isinf(values), -1, np.rint(values * 85)).astype(int)
    assert units.tolist() == twin.fixed_field(costs, goals, allow_unknown)


def test_slices_of_any_size_give_the_same_field(monkeypatch):
    rng = np.random.default_rng(5)
    map_ = grids.of(rng.integers(0, 256, (80, 70)).astype(np.uint8))
    goal = np.array(grids.free_cells(map_.data, True)[:1])
    whole = QueueField(map_, goal)
    whole.grow()
    monkeypatch.setattr(queue_field, "SLICE_CELLS", 1)
    monkeypatch.setattr(queue_field, "SLICE_SETUP", 1)
    sliced = QueueField(map_, goal, threads=2)
    sliced.grow()
    assert np.array_equal(sliced.values(), whole.values())


def test_each_reached_cell_is_settled_once():
    rng = np.random.default_rng(7)
    map_ = grids.of(rng.integers(0, 256, (90, 90)).astype(np.uint8))
    field = QueueField(map_, np.array([grids.free_cells(map_.data, True)[0]]))
    assert field.grow()
    assert field.settled == np.isfinite(field.values()).sum()


def test_a_pool_that_runs_out_grows_and_loses_nothing():
    rng = np.random.default_rng(8)
    map_ = grids.of(rng.integers(0, 253, (1_400, 1_400)).astype(np.uint8))
    goals = np.full((200_000, 2), 700)
    small, large = QueueField(map_, goals[:1]), QueueField(map_, goals)
    chunks = len(small._queue.pool), len(large._queue.pool)
    small.grow()
    large.grow()
    assert len(small._queue.pool) > chunks[0]
    assert len(large._queue.pool) == chunks[1]
    assert np.array_equal(small.values(), large.values())


@given(grids.scenes())
def test_a_field_beyond_32_bits_continues_in_64(scene):
    costs, goals, allow_unknown = scene
    narrow = QueueField(grids.of(costs), np.array(goals), allow_unknown=allow_unknown)
    widened = QueueField(grids.of(costs), np.array(goals), allow_unknown=allow_unknown)
    widened._limit = 16 * 4096 + 20_000
    narrow.grow()
    widened.grow()
    assert np.array_equal(narrow.values(), widened.values())
    if np.nanmax(np.where(np.isinf(narrow.values()), 0, narrow.values())) * 85 > 60_000:
        assert widened._field.dtype == np.int64


def maze(seed, size=61):
    """Carve random corridors one cell wide, with some loops."""
    rng, cells = np.random.default_rng(seed), np.full((size, size), 254, np.uint8)
    stack = [(1, 1)]
    cells[1, 1] = 0
    while stack:
        row, column = stack[-1]
        neighbours = [(row + 2 * r, column + 2 * c) for r, c in ((0, 1), (1, 0), (0, -1), (-1, 0))]
        neighbours = [(r, c) for r, c in neighbours if 0 < r < size and 0 < c < size and cells[r, c] == 254]
        if not neighbours:
            stack.pop()
            continue
        r, c = neighbours[rng.integers(len(neighbours))]
        cells[(row + r) // 2, (column + c) // 2] = cells[r, c] = 0
        stack.append((r, c))
    cells[rng.random(cells.shape) < 0.03] = 0
    cells[cells == 0] = rng.choice([0, 0, 30, 252], np.count_nonzero(cells == 0))
    return cells


@pytest.mark.parametrize("seed", range(6))
def test_corridors_have_the_same_values_as_with_tiles(seed):
    cells = maze(seed)
    goals = np.array(grids.free_cells(cells, True)[:: 400 * (seed + 1)])
    queued, tiled = QueueField(grids.of(cells), goals), TileField(grids.of(cells), goals)
    queued.grow()
    tiled.grow()
    assert np.array_equal(queued.values(), tiled.values())


@pytest.mark.parametrize("seed", range(3))
def test_a_target_in_a_maze_is_final_when_growth_stops_at_it(seed):
    cells = maze(seed)
    free = grids.free_cells(cells, True)
    whole = TileField(grids.of(cells), np.array(free[:1]))
    whole.grow()
    for target in free[:: len(free) // 40]:
        field = QueueField(grids.of(cells), np.array(free[:1]))
        assert field.grow(target)
        assert field.values_at(np.array([target])) == whole.values_at(np.array([target]))
        assert np.array_equal(field.path_from(target), whole.path_from(target))
        assert field.settled == (whole.values() <= whole.values()[target]).sum()


@pytest.mark.parametrize("target", [(1, 1), (70, 60)])
def test_path_cost_equals_the_value_of_its_cell(target):
    map_ = grids.of(np.full((80, 70), 100, np.uint8))
    field = QueueField(map_, np.array([(5, 40)]))
    assert field.grow(target)
    moves = np.abs(np.diff(field.path_from(target), axis=0)).sum(axis=1)
    assert field.values_at(np.array([target]))[0] == pytest.approx(
        130.0 * np.where(moves == 2, 2**0.5, 1.0).sum(), rel=1e-4
    )
