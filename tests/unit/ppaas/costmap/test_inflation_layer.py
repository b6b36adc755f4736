"""Costs of the inflation layer, from distances."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from ppaas.costmap.inflation_layer import inflate
from ppaas.costmap.kernels import inflation as kernels
from ppaas.errors import InvalidMap, InvalidParameter
from tests.reference.maps import maps as twin

DISTANCES = hnp.arrays(
    np.float32, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.floats(0.0, 2.0, width=32)
)
RADII = st.floats(0.0, 1.0)


@given(DISTANCES, st.data(), RADII, RADII, st.floats(0.0, 20.0))
def test_costs_agree_with_the_twin(distance, draw, inscribed, inflation, scaling):
    unknown = draw.draw(hnp.arrays(np.bool_, distance.shape))
    costs = inflate(
        distance,
        inscribed_radius=inscribed,
        inflation_radius=inflation,
        cost_scaling_factor=scaling,
        unknown=unknown,
    )
    assert np.array_equal(
        kernels.inflate_parallel(distance, unknown.view(np.uint8), inscribed, inflation, scaling), costs
    )
    for cell in np.ndindex(*distance.shape):
        d = float(distance[cell])
        if min(abs(d - inscribed), abs(d - inflation)) > 2e-5 or d == 0.0:
            exact = twin.cost(d, bool(unknown[cell]), inscribed, inflation, scaling)
            assert int(costs[cell]) <= exact < int(costs[cell]) + 1 + 1e-9


@given(st.floats(0.01, 1.0), st.integers(0, 20))
def test_radius_of_whole_cells_includes_the_cell_at_that_distance(resolution, cells):
    distance = (np.arange(30) * resolution).astype(np.float32)[None]
    costs = inflate(distance, inscribed_radius=cells * resolution, inflation_radius=cells * resolution)
    assert costs.tolist() == [[254] + [253] * cells + [0] * (29 - cells)]


def test_the_defaults_are_those_of_costmap_2d():
    distance = np.array([[0.0, 0.1, 0.2, 0.3, 0.5, 0.55, 0.6]], np.float32)
    decay = [int(252 * math.exp(-10 * (d - 0.18))) for d in (0.2, 0.3, 0.5, 0.55)]
    assert inflate(distance, inscribed_radius=0.18).tolist() == [[254, 253, *decay, 0]]


def test_costs_never_rise_with_distance():
    distance = np.linspace(0.0, 1.0, 500, dtype=np.float32)[None]
    assert (np.diff(inflate(distance, inscribed_radius=0.2).astype(int)) <= 0).all()


def test_unknown_cells_stay_unknown_unless_the_robot_would_touch_an_obstacle():
    distance = np.array([[0.0, 0.1, 0.3, 9.0]], np.float32)
    costs = inflate(distance, inscribed_radius=0.18, unknown=np.ones((1, 4), np.bool_))
    assert costs.tolist() == [[254, 253, 255, 255]]


def test_an_inflation_radius_below_the_inscribed_one_hides_no_collision():
    distance = np.array([[0.0, 0.1, 0.4, 0.6]], np.float32)
    assert inflate(distance, inscribed_radius=0.5, inflation_radius=0.2).tolist() == [[254, 253, 253, 0]]


def test_large_map_is_inflated_like_a_small_one():
    distance = np.random.default_rng(0).random((500, 400), np.float32)
    unknown = distance > 0.9
    large = inflate(distance, inscribed_radius=0.2, unknown=unknown)
    rows = [inflate(distance[r : r + 1], inscribed_radius=0.2, unknown=unknown[r : r + 1]) for r in range(500)]
    assert np.array_equal(large, np.concatenate(rows))


@pytest.mark.parametrize("name", ["inscribed_radius", "inflation_radius", "cost_scaling_factor"])
@pytest.mark.parametrize("value", [-0.1, math.nan, math.inf])
def test_a_parameter_out_of_range_is_named(name, value):
    with pytest.raises(InvalidParameter, match=name):
        inflate(np.zeros((1, 1), np.float32), **{"inscribed_radius": 0.2, name: value})


@pytest.mark.parametrize("distance", [np.zeros((1, 1)), np.zeros(1, np.float32)])
def test_distances_of_another_kind_are_refused(distance):
    with pytest.raises(InvalidMap, match="float32"):
        inflate(distance, inscribed_radius=0.2)


def test_an_unknown_mask_of_another_shape_is_refused():
    with pytest.raises(InvalidMap, match="float32"):
        inflate(np.zeros((2, 2), np.float32), inscribed_radius=0.2, unknown=np.zeros((2, 1), np.bool_))


def test_warm_calls_every_kernel():
    kernels.warm()
    assert kernels.inflate_serial.nopython_signatures
    assert kernels.inflate_parallel.nopython_signatures
