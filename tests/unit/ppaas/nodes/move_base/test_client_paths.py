"""Paths of clients: which poses are followed, and which of them are free."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.errors import InvalidInput, NoValidPath
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav2_motions import FollowPathGoal
from ppaas.messages.nav2_msgs import IsPathValidRequest, IsPathValidResponse
from ppaas.messages.nav_msgs import Path
from ppaas.nodes.move_base.client_paths import APART, MOST, check_path, path_to_follow, rest_for, rows_of
from ppaas.transforms.planar import TransformTree
from tests.support.world.planar_world import walled_map

COSTMAP = build_layers(walled_map(6, 4, [(3.0, 0.0, 3.4, 2.0)]), robot_radius=0.2).costmap


def path(*points: tuple[float, ...], frame: str = "map", own: str = "") -> Path:
    poses = [PoseStamped(Header(frame_id=own), Pose.of(Pose2D(*point))) for point in points]
    return Path(Header(frame_id=frame), poses)


def kept(*points: tuple[float, ...]) -> list[Pose2D]:
    return list(path_to_follow(FollowPathGoal(path(*points)), TransformTree()))


def test_poses_nearer_than_is_followed_are_left_out_but_for_the_last() -> None:
    along = [*((k / 16, 0.0) for k in range(17)), (1.05, 0.0)]
    assert [pose.x for pose in kept(*along)] == [*(k / 8 for k in range(9)), 1.05]


def test_poses_without_a_frame_are_in_that_of_the_path() -> None:
    tree = TransformTree()
    tree.set_static("map", "hall", Pose2D(2.0, 1.0))
    for each in (path((1.0, 0.0), frame="hall"), path((1.0, 0.0), own="hall")):
        assert path_to_follow(FollowPathGoal(each), tree) == (Pose2D(3.0, 1.0),)


@pytest.mark.parametrize(
    ("points", "text"),
    [
        ([], "nothing to follow"),
        ([(0.0, 0.0), (2000.0, 0.0)], "at most 1000 m long, not 2000 m"),
        ([(0.0, 0.0)] * (MOST + 1), f"at most {MOST} poses, not {MOST + 1}"),
        ([(0.0, float("nan"))], "pose 1 must be finite"),
    ],
)
def test_a_path_that_cannot_be_followed_is_refused(points: list[tuple[float, float]], text: str) -> None:
    with pytest.raises(InvalidInput, match=text):
        kept(*points)


@given(st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)), min_size=1, max_size=9))
def test_rows_pass_all_poses_in_short_steps(points: list[tuple[float, float, float]]) -> None:
    rows = rows_of([Pose2D(*point) for point in points])
    assert np.hypot(*np.diff(rows[:, :2], axis=0).T).max(initial=0.0) <= APART + 1e-9
    for x, y, _ in points:
        assert np.hypot(rows[:, 0] - x, rows[:, 1] - y).min() < 1e-9


def test_a_round_trip_is_begun_at_its_begin() -> None:
    rows = rows_of([Pose2D(*point) for point in ((0, 0), (2, 0), (2, 2), (0, 2), (0, 0.02))])
    rest = rest_for(rows, Pose2D(0.0, 0.02))
    assert len(rest) == len(rows)
    with pytest.raises(NoValidPath, match=r"1\.50 m away from the path"):
        rest_for(rows, Pose2D(-1.5, 0.0))


def invalid(points: list[tuple[float, float]], pose: Pose2D | None = None, **fields: object) -> list[int]:
    fields = {"stop_at_first_collision": False, **fields}
    answer = check_path(IsPathValidRequest(path(*points), **fields), COSTMAP, TransformTree(), pose)  # type: ignore[arg-type]
    assert isinstance(answer, IsPathValidResponse)
    assert answer.is_valid == (not answer.invalid_pose_indices)
    return answer.invalid_pose_indices


THROUGH = [(1.0, 1.0), (2.0, 1.0), (3.2, 1.0), (4.4, 1.0), (3.2, 1.0)]


def test_poses_in_obstacles_and_outside_the_map_are_not_free() -> None:
    assert invalid(THROUGH) == [2, 4]
    assert invalid(THROUGH, stop_at_first_collision=True) == [2]
    assert invalid([(1.0, 1.0), (7.0, 1.0)]) == [1]
    assert invalid([(1.0, 1.0), (2.9, 1.0)]) == [1], "the robot would touch the obstacle"


def test_what_is_behind_the_robot_or_too_far_ahead_is_not_checked() -> None:
    assert invalid(THROUGH[:4], Pose2D(4.3, 1.0)) == []
    assert invalid(THROUGH, Pose2D(1.0, 1.0), max_lookahead_distance=1.0) == []
    assert invalid(THROUGH, Pose2D(1.0, 1.0), max_lookahead_distance=3.0) == [2]


def test_costs_count_up_to_the_most_that_is_allowed() -> None:
    near = [(1.0, 1.0), (2.6, 1.0)]
    assert invalid(near) == []
    assert invalid(near, max_cost=1) == [1]
    with pytest.raises(InvalidInput, match="leave layer_name and footprint empty"):
        invalid(near, layer_name="static_layer")


def test_unknown_cells_are_free_unless_they_count_as_obstacles() -> None:
    grid = walled_map(6, 4, [])
    grid.data[20:40, 60:80] = -1
    unknown = build_layers(grid, robot_radius=0.2).costmap
    for counts in (False, True):
        request = IsPathValidRequest(path((1.0, 1.0), (3.5, 1.5)), consider_unknown_as_obstacle=counts)
        answer = check_path(request, unknown, TransformTree(), None)
        assert isinstance(answer, IsPathValidResponse)
        assert answer.is_valid == (not counts)
