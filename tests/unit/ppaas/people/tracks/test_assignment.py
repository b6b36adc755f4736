"""Assignment of observations to people: the least sum of costs, and a gate."""

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.optimize import linear_sum_assignment

from ppaas.people.tracks.assignment import assign
from ppaas.people.tracks.hungarian import least_cost

LIMIT = 5.0


def total(costs: np.ndarray, pairs: tuple[np.ndarray, np.ndarray]) -> float:
    """Return the sum of costs, of which each row without a column costs the limit."""
    rows, columns = pairs
    return float(costs[rows, columns].sum() + LIMIT * (len(costs) - len(rows)))


def least(costs: np.ndarray) -> float:
    """Return the least sum over all assignments, by trying them all."""
    wide = np.concatenate((np.minimum(costs, LIMIT), np.full((len(costs), len(costs)), LIMIT)), axis=1)
    return min(
        sum(wide[row, column] for row, column in enumerate(columns))
        for columns in permutations(range(wide.shape[1]), len(costs))
    )


@given(arrays(np.float64, st.tuples(st.integers(1, 3), st.integers(0, 3)), elements=st.floats(0.0, 8.0)))
def test_the_sum_of_costs_is_the_least_of_all_assignments(costs: np.ndarray) -> None:
    rows, columns = assign(costs, LIMIT)
    assert len(set(rows)) == len(rows) and len(set(columns)) == len(columns)
    assert (costs[rows, columns] < LIMIT).all()
    assert total(costs, (rows, columns)) == pytest.approx(least(costs))


def test_the_nearest_pair_is_given_up_for_a_better_sum() -> None:
    rows, columns = assign(np.array([[0.5, 1.0], [1.0, 4.9]]), LIMIT)
    assert (rows.tolist(), columns.tolist()) == ([0, 1], [1, 0])


def test_beyond_the_gate_nothing_is_assigned() -> None:
    rows, columns = assign(np.array([[LIMIT, np.inf]]), LIMIT)
    assert len(rows) == len(columns) == 0


@given(arrays(np.float64, array_shapes(min_dims=2, max_dims=2, max_side=7), elements=st.floats(-50.0, 50.0)))
def test_assignment_costs_as_little_as_that_of_scipy(costs: np.ndarray) -> None:
    rows, columns = least_cost(costs)
    assert len(rows) == len(columns) == min(costs.shape)
    assert sorted(rows.tolist()) == rows.tolist()
    assert len(set(rows.tolist())) == len(set(columns.tolist())) == len(rows)
    assert np.isclose(costs[rows, columns].sum(), costs[linear_sum_assignment(costs)].sum())
