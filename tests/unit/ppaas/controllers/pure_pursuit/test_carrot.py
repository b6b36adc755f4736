import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.pure_pursuit.carrot import carrot_at, curvature_to, legs_of
from ppaas.geometry import Pose2D, poses_along
from tests.reference.driving import controllers

poses = st.builds(Pose2D, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.1, 3.1))


@given(seed=st.integers(0, 10_000), pose=poses, distance=st.floats(0.1, 2.0))
def test_carrot_agrees_with_the_twin(seed, pose, distance):
    points = np.random.default_rng(seed).normal(0.15, 0.3, (12, 2)).cumsum(axis=0)
    x, y = controllers.carrot(points, (pose.x, pose.y), distance)
    there = pose @ carrot_at(points, pose, distance)
    assert (there.x, there.y) == pytest.approx((x, y), abs=0.005)


@given(x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0))
def test_arc_is_tangent_to_the_heading_and_passes_the_point(x, y):
    curvature = curvature_to(Pose2D(x, y))
    if abs(curvature) < 1e-6:
        assert abs(y) < 1e-5
    else:
        radius = 1.0 / curvature
        assert math.hypot(x, y - radius) == pytest.approx(abs(radius), rel=1e-6)


def test_plan_is_split_where_it_reverses():
    x = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.5, 1.5])
    plan = poses_along(np.stack((x, np.zeros(7)), axis=1), 1.0)
    legs = legs_of(plan)
    assert [leg[[0, -1], 0].tolist() for leg in legs] == [[0.0, 2.0], [2.0, 0.5], [0.5, 1.5]]
    assert (legs[-1][-1] == plan[-1]).all()
    assert sum(len(leg) for leg in legs) == len(plan) + 2


@pytest.mark.parametrize("points", [[(1.0, 2.0)], [(1.0, 2.0)] * 3, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]])
def test_plan_without_reversals_is_one_leg(points):
    plan = poses_along(np.array(points))
    (leg,) = legs_of(plan)
    assert (leg == plan).all()
