import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.units import CARDINAL, DIAGONAL, RELATIVE_ERROR, unit_weights
from ppaas.planners.weights import exact_weights, passable


@given(st.sets(st.integers(0, 255)), st.booleans())
def test_units_are_in_proportion_to_the_weights(costs, allow_unknown):
    occurring = np.isin(np.arange(256), list(costs))
    units = unit_weights(occurring, allow_unknown)
    entered = np.flatnonzero(occurring & passable(allow_unknown))
    assert np.flatnonzero(units[0]).tolist() == entered.tolist()
    if entered.size:
        ratios = units[0, entered] / exact_weights()[entered]
        np.testing.assert_allclose(ratios, ratios[0], rtol=1e-12)
        assert np.array_equal(units[0] * DIAGONAL, units[1] * CARDINAL)


def test_diagonal_is_the_root_of_two_within_the_stated_error():
    assert abs(DIAGONAL / CARDINAL / math.sqrt(2.0) - 1.0) <= RELATIVE_ERROR < 1e-8


@pytest.mark.parametrize("cost", [0, 1, 252, 255])
def test_a_map_of_one_cost_is_counted_in_cells(cost):
    units = unit_weights(np.arange(256) == cost, True)
    assert units[:, cost].tolist() == [CARDINAL, DIAGONAL]


def test_a_map_without_a_free_cell_has_no_weights():
    assert not unit_weights(np.arange(256) == 254, True).any()
