"""Linear assignment: as cheap as that of scipy."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from scipy.optimize import linear_sum_assignment

from ppaas.people.tracks.hungarian import least_cost


@given(arrays(np.float64, array_shapes(min_dims=2, max_dims=2, max_side=7), elements=st.floats(-50.0, 50.0)))
def test_assignment_costs_as_little_as_that_of_scipy(costs: np.ndarray) -> None:
    rows, columns = least_cost(costs)
    assert len(rows) == len(columns) == min(costs.shape)
    assert sorted(rows.tolist()) == rows.tolist()
    assert len(set(rows.tolist())) == len(set(columns.tolist())) == len(rows)
    assert np.isclose(costs[rows, columns].sum(), costs[linear_sum_assignment(costs)].sum())
