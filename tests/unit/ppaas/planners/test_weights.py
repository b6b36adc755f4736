import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.field.kernels.layout import BUCKET_SHIFT, RING
from ppaas.planners.units import CARDINAL, DIAGONAL, unit_weights
from ppaas.planners.units import RELATIVE_ERROR as UNIT_ERROR
from ppaas.planners.weights import RELATIVE_ERROR, SCALE, exact_weights, fixed_weights, passable


@pytest.mark.parametrize(("cost", "weight"), [(0, 50.0), (1, 50.8), (252, 251.6), (253, 252.4), (255, 253.0)])
def test_weights_are_those_of_navfn(cost, weight):
    assert exact_weights()[cost] == pytest.approx(weight)


def test_obstacle_has_infinite_weight():
    assert math.isinf(exact_weights()[254])


def test_fixed_point_weights_are_exact_or_within_the_error_bound():
    finite = np.arange(256) != 254
    exact, fixed = exact_weights()[finite], fixed_weights()[:, finite]
    np.testing.assert_allclose(fixed[0], exact * SCALE, rtol=1e-13)
    assert np.all(np.abs(fixed[1] / SCALE / (exact * math.sqrt(2.0)) - 1.0) <= RELATIVE_ERROR)


def test_every_move_ends_in_another_bucket_within_the_ring():
    moves = fixed_weights()[:, np.arange(256) != 254]
    assert moves.min() >= 1 << BUCKET_SHIFT
    assert (moves.max() >> BUCKET_SHIFT) + 2 <= RING


def test_unknown_cells_are_passable_only_if_allowed():
    assert passable(True)[[0, 252, 253, 254, 255]].tolist() == [True, True, False, False, True]
    assert passable(False)[[0, 252, 253, 254, 255]].tolist() == [True, True, False, False, False]


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
    assert abs(DIAGONAL / CARDINAL / math.sqrt(2.0) - 1.0) <= UNIT_ERROR < 1e-8


@pytest.mark.parametrize("cost", [0, 1, 252, 255])
def test_a_map_of_one_cost_is_counted_in_cells(cost):
    units = unit_weights(np.arange(256) == cost, True)
    assert units[:, cost].tolist() == [CARDINAL, DIAGONAL]


def test_a_map_without_a_free_cell_has_no_weights():
    assert not unit_weights(np.arange(256) == 254, True).any()
