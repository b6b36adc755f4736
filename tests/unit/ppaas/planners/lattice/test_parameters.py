"""The parameters of the kinematic planner are Nav2's, and invalid values are refused."""

import math

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidParameter
from ppaas.geometry import convex_outline
from ppaas.planners import create
from ppaas.planners.lattice.parameters import LatticeParameters
from ppaas.planners.lattice.search import reweighted_costs
from ppaas.planners.weights import exact_weights
from ppaas.plugins import parameters_in_use


@pytest.mark.parametrize(
    ("parameters", "text"),
    [
        ({"minimum_turning_radius": 0.0}, "minimum_turning_radius must be above 0"),
        ({"minimum_turning_radius": math.nan}, "minimum_turning_radius must be finite"),
        ({"motion_model_for_search": "MOORE"}, "motion_model_for_search must be DUBIN or REEDS_SHEPP"),
        ({"angle_quantization_bins": 4}, "angle_quantization_bins"),
        ({"angle_quantization_bins": 72.5}, "Expected `int`, got `float` - at `\\$.angle_quantization_bins`"),
        ({"reverse_penalty": 0.5}, "reverse_penalty must be at least 1"),
        ({"cost_penalty": 4.5}, "cost_penalty must be at most 4"),
        ({"retrospective_penalty": 1.0}, "retrospective_penalty must be below 1"),
        ({"allow_unknown": 1}, "Expected `bool`, got `int` - at `\\$.allow_unknown`"),
        ({"max_planning_time": "5"}, "Expected `float`, got `str` - at `\\$.max_planning_time`"),
        ({"footprint": [[0.1, 0.2], [0.3, 0.4]]}, "footprint must be a list of at least three corners"),
        ({"footprint": [[0.1, 0.2], [0.3]]}, "footprint"),
        ({"footprint": [[0.1, math.nan], [0.3, 0.2], [0.3, 0.4]]}, "footprint"),
        ({"footprint": "round"}, "footprint"),
        ({"lattice_filepath": "a.json"}, "lattice_filepath.*known: .*allow_unknown, "),
    ],
)
def test_invalid_parameters_are_refused_by_name(parameters, text):
    with pytest.raises(InvalidParameter, match=text):
        create("lattice", **parameters)


def test_whole_and_decimal_numbers_give_the_same_plan_conditions():
    whole, decimal = create("lattice", tolerance=1), create("lattice", tolerance=1.0)
    encoded = msgspec.json.encode(parameters_in_use(whole))
    assert encoded == msgspec.json.encode(parameters_in_use(decimal))
    assert b'"tolerance":1.0' in encoded


def test_max_iterations_of_minus_one_is_valid():
    assert LatticeParameters(max_iterations=-1).max_iterations == -1


def test_the_outline_of_a_hollow_footprint_is_the_smallest_convex_one():
    hollow = [(1.0, 1.0), (0.2, 0.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0), (0.0, 1.0)]
    assert convex_outline(np.array(hollow)).tolist() == [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]


@given(st.integers(0, 2**32 - 1))
def test_outline_is_convex_and_contains_all_points(seed):
    points = np.random.default_rng(seed).normal(size=(9, 2))
    outline = convex_outline(points)
    edges = np.roll(outline, -1, axis=0) - outline
    assert {tuple(corner) for corner in outline.tolist()} <= {tuple(point) for point in points.tolist()}
    for corner, (dx, dy) in zip(outline, edges, strict=True):
        off = points - corner
        assert (dx * off[:, 1] - dy * off[:, 0] >= -1e-12).all()


@given(st.floats(0.0, 4.0), st.booleans())
def test_costs_follow_the_penalty_and_blocked_costs_stay_blocked(penalty, allow_unknown):
    table = reweighted_costs(LatticeParameters(cost_penalty=penalty, allow_unknown=allow_unknown))
    weighed = exact_weights()[table[:253]] / 50.0
    wanted = 1.0 + penalty * np.arange(253) / 252.0
    assert (np.abs(weighed - wanted) <= 0.0161).all()
    assert table[[253, 254]].tolist() == [253, 254]
    assert (table[255] < 253) == allow_unknown
