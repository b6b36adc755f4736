"""Reuse of prepared maps, and arrays that grow."""

import numpy as np
import pytest

from ppaas.planners import array_growth
from ppaas.planners.base import PlanRequest
from ppaas.planners.prepared import Prepared, PreparedPlanner
from ppaas.planners.watch import proceed
from tests.support.world import grids


class StraightAcross(Prepared):
    """Search that follows the row of the start."""

    nbytes = 0
    expanded = 7

    def path(self, start_row, start_column, goal_row, goal_column, check=lambda: None):
        """Return the cells of a row."""
        columns = np.arange(start_column, goal_column + 1, dtype=np.int32)
        return np.column_stack((np.full_like(columns, start_row), columns))

    def twin(self):
        """Return another."""
        return StraightAcross()


class Straight(PreparedPlanner):
    """Planner that counts its preparations."""

    name = "straight"
    purpose = "For tests."

    def __init__(self) -> None:
        super().__init__()
        self.prepared_data = []

    def prepare(self, costmap, *, threads=1, check=lambda: None):
        """Count a preparation."""
        self.prepared_data.append(costmap.data)
        return StraightAcross()


def plan(planner, costmap):
    ends = grids.centre(costmap, 0, 0), grids.centre(costmap, 0, 2)
    return planner.plan(costmap, PlanRequest(*ends))


def test_a_read_only_map_is_prepared_once() -> None:
    planner, costmap = Straight(), grids.costmap("...")
    costmap.data.flags.writeable = False
    results = [plan(planner, costmap) for _ in range(3)]
    assert len(planner.prepared_data) == 1
    assert all(result.cells.tolist() == [[0, 0], [0, 1], [0, 2]] for result in results)
    assert {(result.expanded, result.cost) for result in results} == {(7, 100.0)}


def test_a_writable_map_is_prepared_for_each_plan() -> None:
    planner, costmap = Straight(), grids.costmap("...")
    plan(planner, costmap)
    plan(planner, costmap)
    assert len(planner.prepared_data) == 2


def test_equal_but_other_map_is_prepared_again() -> None:
    planner, costmaps = Straight(), [grids.costmap("..."), grids.costmap("...")]
    for costmap in costmaps:
        costmap.data.flags.writeable = False
    for costmap in costmaps:
        plan(planner, costmap)
    assert [data is costmap.data for data, costmap in zip(planner.prepared_data, costmaps, strict=True)] == [True, True]


@pytest.mark.parametrize("shape", [(1,), (7,), (5, 2)])
def test_the_doubled_array_begins_with_the_old_items(shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(array_growth, "SLICE_COPIED", 12)
    before = np.arange(np.prod(shape), dtype=np.int32).reshape(shape)
    after = array_growth.doubled(before, proceed)
    assert after.shape == (2 * shape[0], *shape[1:]) and after.dtype == before.dtype
    assert (after[: len(before)] == before).all()


def test_check_is_called_for_each_slice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(array_growth, "SLICE_COPIED", 8)
    checks: list[int] = []
    array_growth.doubled(np.zeros(6, np.int32), lambda: checks.append(1))
    assert len(checks) == 3
