import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.planar_poses import compose, differences, inverse, relative, rotated, symmetric, upper_triangle, wrap_angles

coordinates = st.floats(-100.0, 100.0)
poses = st.tuples(coordinates, coordinates, st.floats(-math.pi, math.pi, exclude_max=True))


@given(st.lists(st.tuples(poses, poses), min_size=1, max_size=5))
def test_arrays_agree_with_single_poses(pairs):
    first, second = np.array(pairs).transpose(1, 0, 2)
    composed = [Pose2D(*a) @ Pose2D(*b) for a, b in pairs]
    seen = [Pose2D(*a).inverse() @ Pose2D(*b) for a, b in pairs]
    assert_same(compose(first, second), composed)
    assert_same(relative(first, second), seen)
    assert_same(inverse(first), [Pose2D(*a).inverse() for a, _ in pairs])


def assert_same(found, expected):
    difference = found - np.array(expected)
    difference[:, 2] = wrap_angles(difference[:, 2])
    assert np.abs(difference).max() < 1e-9


def test_one_pose_is_composed_with_many():
    many = np.arange(12.0).reshape(2, 2, 3)
    assert compose(np.array([1.0, 2.0, 0.0]), many)[..., :2] == pytest.approx(many[..., :2] + (1.0, 2.0))


def test_upper_triangle_makes_a_symmetric_matrix():
    matrix = np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 5.0], [3.0, 5.0, 6.0]])
    assert upper_triangle(matrix).tolist() == [1, 2, 3, 4, 5, 6]
    assert (symmetric(upper_triangle(matrix)) == matrix).all()


def test_rotated_covariance_has_its_axes_turned():
    turned = rotated(np.diag([4.0, 1.0, 9.0]), math.pi / 2)
    assert turned == pytest.approx(np.diag([1.0, 4.0, 9.0]), abs=1e-12)
    many = rotated(np.tile(np.diag([4.0, 1.0, 9.0]), (2, 1, 1)), np.array([0.0, math.pi / 2]))
    assert many[1] == pytest.approx(turned)


def test_differences_have_wrapped_headings_and_leave_the_poses():
    first, second = np.array([[1.0, 2.0, 3.0]]), np.array([[0.5, 4.0, -3.0]])
    assert differences(first, second) == pytest.approx(np.array([[0.5, -2.0, 6.0 - 2.0 * math.pi]]))
    assert first.tolist() == [[1.0, 2.0, 3.0]]
