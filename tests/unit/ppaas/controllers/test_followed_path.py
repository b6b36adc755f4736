import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.controllers.followed_path import FollowedPath
from ppaas.controllers.kernels import followed_path as kernels
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, poses_along
from ppaas.maps.grid import GridInfo
from tests.reference.driving import controllers as twin
from tests.support.world import grids


def straight(length=5.0, step=0.05):
    x = np.arange(0.0, length + step / 2, step)
    return FollowedPath(poses_along(np.stack((x, np.zeros_like(x)), axis=1), 0.7))


def test_the_end_is_the_last_pose():
    assert straight().end == pytest.approx((5.0, 0.0, 0.7))


def test_remaining_length_is_measured_along_the_plan():
    corner = FollowedPath(poses_along(np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])))
    corner.locate(Pose2D(0.9, 0.0))
    assert corner.to_go(Pose2D(0.9, 0.0)) == pytest.approx(math.hypot(0.1, 1.0), abs=0.15)
    path = straight()
    path.locate(Pose2D(2.0, 0.1))
    assert path.to_go(Pose2D(2.0, 0.1)) == pytest.approx(3.0, abs=0.11)


def test_plan_that_returns_beside_itself_is_followed_in_order():
    out = np.stack((np.arange(0.0, 4.0, 0.05), np.zeros(80)), axis=1)
    path = FollowedPath(poses_along(np.concatenate((out, out[::-1] + np.array((0.0, 0.1))))))
    for x in np.arange(0.0, 3.0, 0.05):
        path.locate(Pose2D(float(x), 0.08))
        assert path.point_ahead(0.3)[0] == pytest.approx(x + 0.3, abs=0.06)


def test_moved_robot_is_located_again():
    path = straight()
    path.locate(Pose2D(0.1, 0.0))
    path.locate(Pose2D(4.0, 0.2))
    assert path.point_ahead(0.5) == pytest.approx((4.5, 0.0))


def test_the_point_ahead_stops_at_the_end():
    path = straight()
    path.locate(Pose2D(4.9, 0.0))
    assert path.point_ahead(3.0) == pytest.approx((5.0, 0.0))


def test_points_ahead_have_decreasing_remaining_lengths():
    path = straight()
    path.locate(Pose2D(1.0, 0.0))
    points, remaining = path.ahead(1.5, grids.of(np.zeros((100, 100), np.uint8), 0.1, Pose2D(-5.0, -5.0)))
    assert points[-1] == pytest.approx((2.5, 0.0))
    assert remaining[-1] == 0.0
    np.testing.assert_allclose(-np.diff(remaining), np.hypot(*np.diff(points, axis=0).T))


def test_points_ahead_end_at_the_edge_of_the_costmap():
    path = straight()
    path.locate(Pose2D(1.0, 0.0))
    points, _ = path.ahead(4.0, grids.of(np.zeros((20, 20), np.uint8), 0.1, Pose2D(0.0, -1.0)))
    assert 1.9 <= points[-1, 0] < 2.0


def test_plan_of_one_pose_is_valid():
    path = FollowedPath(poses_along(np.array([(1.0, 2.0)]), 0.3))
    path.locate(Pose2D(0.0, 0.0))
    points, remaining = path.ahead(1.0, grids.of(np.zeros((50, 50), np.uint8), 0.1))
    assert np.all(points == (1.0, 2.0))
    assert np.all(remaining == 0.0)


@pytest.mark.parametrize("poses", [np.empty((0, 7)), np.zeros((3, 2)), np.zeros(7), np.full((2, 7), np.nan)])
def test_invalid_plan_is_refused(poses):
    with pytest.raises(InvalidInput, match="plan"):
        FollowedPath(poses)


coordinates = st.floats(-3.0, 3.0).map(lambda value: round(value, 2))
places = st.tuples(coordinates, coordinates)
kernel_grids = st.builds(
    GridInfo, st.sampled_from((0.05, 0.1)), st.integers(5, 60), st.integers(5, 60),
    st.builds(Pose2D, coordinates, coordinates, st.floats(-3.0, 3.0)),
)  # fmt: skip

Plan = tuple[NDArray[np.float64], NDArray[np.float64]]


@st.composite
def plans(draw: st.DrawFn) -> Plan:
    """Draw a plan of several corners; some points are equal, and some plans have one."""
    corners = np.array(draw(st.lists(places, min_size=1, max_size=5)))
    parts = [corners[:1]]
    for begin, end in itertools.pairwise(corners):
        parts.append(begin + np.linspace(0.0, 1.0, draw(st.integers(1, 40)))[:, None] * (end - begin))
    points = np.concatenate(parts)
    steps = np.diff(points, axis=0)
    return points, np.concatenate(([0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))


@given(plan=plans(), robot=st.lists(places, min_size=1, max_size=4))
def test_robots_are_located_as_by_the_twin(plan: Plan, robot: list[tuple[float, float]]) -> None:
    reached = 0
    for x, y in robot:
        expected = twin.locate(*plan, reached, x, y)
        reached = kernels.locate(*plan, reached, x, y)
        assert reached == expected


@given(plan=plans(), s=st.floats(-1.0, 30.0))
def test_points_of_a_plan_are_those_of_the_twin(plan: Plan, s: float) -> None:
    for at in (s, *plan[1][:3].tolist(), float(plan[1][-1])):
        assert kernels.point_at(*plan, at) == twin.point_at(*plan, at)


@given(plan=plans(), reached=st.integers(0, 1 << 16), distance=st.floats(0.0, 6.0), info=kernel_grids)
def test_the_plan_ahead_is_that_of_the_twin(plan: Plan, reached: int, distance: float, info: GridInfo) -> None:
    reached %= len(plan[0])
    points, remaining = kernels.points_ahead(
        *plan, reached, distance, tuple(map(float, info.origin)), info.resolution, info.shape
    )
    expected, left = twin.points_ahead(*plan, reached, distance, info)
    np.testing.assert_array_equal(points, expected)
    np.testing.assert_array_equal(remaining, left)
