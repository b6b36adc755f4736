"""Costs of the inflation layer, from distances and its parameters; distances around new obstacles."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from ppaas.costmap.global_parameters import CostParameters, GlobalCostmapParameters
from ppaas.costmap.inflation_layer import inflate
from ppaas.costmap.kernels import inflation as kernels
from ppaas.costmap.kernels.near_obstacles import FEW, are_few, lower_near, reach_in_cells
from ppaas.errors import InvalidMap, InvalidParameter
from ppaas.maps.kernels.distance import distance_serial
from ppaas.parameters import read_parameters
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


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({"inflation_radius": -0.1}, "inflation_radius must be from 0 to 100, not -0.1"),
        ({"inflation_radius": 101}, "inflation_radius must be from 0 to 100"),
        ({"inflation_radius": math.nan}, "inflation_radius"),
        ({"cost_scaling_factor": math.inf}, "cost_scaling_factor must be from 0 to 1e"),
        ({"lethal_cost_threshold": 0}, "lethal_cost_threshold must be from 1 to 100, not 0"),
        ({"lethal_cost_threshold": 101}, "lethal_cost_threshold"),
        ({"lethal_cost_threshold": 65.5}, "lethal_cost_threshold"),
        ({"inflation_radius": "wide"}, "inflation_radius"),
        ({"inflation": 0.5}, "known: cost_scaling_factor, footprint, inflation_radius, lethal_cost_threshold, robot_"),
    ],
)
def test_parameters_out_of_range_are_refused_by_name(given, reason):
    with pytest.raises(InvalidParameter, match=reason):
        read_parameters(GlobalCostmapParameters, "global_costmap", given)


def test_only_costs_that_differ_from_the_defaults_are_changed():
    assert GlobalCostmapParameters(robot_radius=0.3, inflation_radius=0.55).changed == {}
    given = read_parameters(GlobalCostmapParameters, "global_costmap", {"inflation_radius": 1, "robot_radius": 1})
    assert given.changed == {"inflation_radius": 1.0}
    assert given.costs == CostParameters(inflation_radius=1.0)


shapes = st.tuples(st.integers(1, 24), st.integers(1, 24))


@given(
    masks=shapes.flatmap(lambda shape: st.tuples(*[hnp.arrays(np.bool_, shape, fill=st.just(False))] * 2)),
    reach=st.integers(0, 12),
)
def test_distances_are_those_to_all_obstacles_as_far_as_they_reach(
    masks: tuple[NDArray[np.bool_], NDArray[np.bool_]], reach: int
) -> None:
    known, new = masks
    distance = distance_serial(known.view(np.uint8), 0.05)
    lower_near(new.view(np.uint8), 0.05, reach, distance)
    expected = distance_serial((known | new).view(np.uint8), 0.05)
    near = expected <= 0.05 * reach + 1e-6
    np.testing.assert_allclose(distance[near], expected[near], rtol=3e-7)
    assert (distance[~near] > 0.05 * reach + 1e-6).all()
    assert ((distance == 0.0) == (expected == 0.0)).all()


def test_many_obstacles_are_left_to_the_transform_of_the_whole_grid() -> None:
    new = np.zeros((60, 60), np.bool_)
    assert are_few(new, 11)
    new[:10] = True
    assert FEW * new.size < 600 * 23**2
    assert not are_few(new, 11)


def test_distances_are_exact_up_to_the_last_cell_with_costs() -> None:
    assert [reach_in_cells(distance, 0.05) for distance in (0.0, 0.05, 0.549, 0.55)] == [1, 2, 11, 12]
