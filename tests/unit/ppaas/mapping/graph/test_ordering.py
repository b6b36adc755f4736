import numpy as np
import pytest

from ppaas.mapping.graph import block_cholesky
from ppaas.mapping.graph.block_cholesky import plan_elimination


def grid_pairs(side):
    nodes = np.arange(side * side).reshape(side, side)
    across = np.column_stack((nodes[:, :-1].ravel(), nodes[:, 1:].ravel()))
    down = np.column_stack((nodes[:-1].ravel(), nodes[1:].ravel()))
    return np.vstack((across, down)).T


@pytest.fixture(params=[(0, 0.0), (4, 0.25), (1000, 1.0)], ids=["exact", "relaxed", "dense"])
def plan(request, monkeypatch):
    monkeypatch.setattr(block_cholesky, "SMALL_FRONT", request.param[0])
    monkeypatch.setattr(block_cholesky, "ZERO_SHARE", request.param[1])
    return plan_elimination(144, *grid_pairs(12))


def test_fronts_cover_all_columns_and_hold_all_entries(plan):
    assert sorted(plan.labels) == list(range(144))
    assert plan.starts[0] == 0 and plan.starts[-1] == 144
    for s, begin in enumerate(plan.starts[:-1]):
        rows = plan.rows[plan.row_starts[s] : plan.row_starts[s + 1]]
        columns = np.arange(begin, plan.starts[s + 1])
        assert (rows[: len(columns)] == columns).all() and (np.diff(rows) > 0).all()
        for column in columns:
            assert np.isin(plan.entry_rows[plan.entry_starts[column] : plan.entry_starts[column + 1]], rows).all()


def test_rows_below_a_front_are_in_its_parents(plan):
    fronts = [set(plan.rows[plan.row_starts[s] : plan.row_starts[s + 1]]) for s in range(len(plan.children))]
    owner = np.repeat(np.arange(len(plan.children)), np.diff(plan.starts))
    children = np.zeros_like(plan.children)
    for s, rows in enumerate(fronts):
        below = {row for row in rows if row >= plan.starts[s + 1]}
        if below:
            parent = owner[min(below)]
            children[parent] += 1
            assert below <= fronts[parent]
    assert (children == plan.children).all()


def test_order_of_a_grid_has_little_fill():
    side = 60
    plan = plan_elimination(side * side, *grid_pairs(side))
    band = side * side * side * 9  # numbers in the factor of the order by rows
    assert plan.size < 0.6 * band
