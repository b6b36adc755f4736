import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas import planners
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOutsideMap, InvalidInput, PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.messages import decode, encode
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.nav_msgs import Path
from ppaas.planners.base import PlanRequest
from ppaas.planners.kernels.path_poses import BLOCK
from ppaas.planners.kernels.pose_text import BLOCK as TEXT_BLOCK
from ppaas.planners.kernels.pose_text import MAX_MAGNITUDE, WIDEST, write_rows
from ppaas.planners.path import FEW, path_cost, path_length, path_poses, poses_through
from ppaas.planners.path_json import path_message, rows_text
from ppaas.planners.through_poses import plan_through
from tests.reference.planners import path as twin
from tests.reference.planners.path import slow_cost, slow_poses
from tests.support.world.planar_world import walled_map

SIDE = 64
MOVES = np.array([(row, column) for row in (-1, 0, 1) for column in (-1, 0, 1) if row or column])


def _costmap(seed: int = 0, origin: Pose2D = Pose2D(-3.0, 7.0, 0.4)) -> Costmap:
    costs = np.random.default_rng(seed).integers(0, 253, (SIDE, SIDE), np.uint8)
    return Costmap(costs, GridInfo(0.05, SIDE, SIDE, origin))


def _walk(seed: int, count: int) -> np.ndarray:
    """Return cells each of which is a neighbour of the one before."""
    rng, cells = np.random.default_rng(seed), np.full((count, 2), SIDE // 2, np.int32)
    for at in range(1, count):
        moves = cells[at - 1] + MOVES
        inside = moves[((moves >= 0) & (moves < SIDE)).all(axis=1)]
        cells[at] = rng.choice(inside)
    return cells


def _ends(costmap: Costmap, cells: np.ndarray) -> tuple[Pose2D, Pose2D]:
    first, last = (costmap.info.to_world(cells[at]) for at in (0, -1))
    return Pose2D(first[0] + 0.01, first[1], 1.0), Pose2D(last[0], last[1] - 0.01, -2.0)


@given(st.integers(0, 1000), st.integers(1, 40), st.floats(-math.pi, math.pi))
def test_poses_and_cost_agree_with_the_definition(seed, count, yaw):
    costmap, cells = _costmap(seed, Pose2D(1.0, -2.0, yaw)), _walk(seed, count)
    start, goal = _ends(costmap, cells)
    listed = list(map(tuple, cells.tolist()))
    poses, slow = path_poses(costmap, cells, start, goal), np.array(slow_poses(costmap, listed, start, goal))
    assert poses[:, :5] == pytest.approx(slow[:, :5], abs=1e-9)
    # A half turn to the left and one to the right are the same heading.
    assert np.abs((poses[:, 5:] * slow[:, 5:]).sum(axis=1)) == pytest.approx(np.ones(count), abs=1e-9)
    assert path_cost(costmap, cells) == pytest.approx(slow_cost(costmap, listed))


def test_poses_of_a_long_path_do_not_depend_on_threads():
    costmap, cells = _costmap(), _walk(1, FEW + BLOCK + 5)
    alone, together = (path_poses(costmap, cells, *_ends(costmap, cells), threads=threads) for threads in (1, 2))
    assert alone.tobytes() == together.tobytes()
    assert path_poses(costmap, cells[:BLOCK], *_ends(costmap, cells[:BLOCK]))[1:-2].tobytes() == (
        together[1 : BLOCK - 2].tobytes()
    )


def test_equal_moves_have_equal_headings_everywhere():
    costmap, cells = _costmap(), np.stack((np.arange(SIDE), np.arange(SIDE)), axis=1).astype(np.int32)
    poses = path_poses(costmap, cells, *_ends(costmap, cells))
    assert len(np.unique(poses[1:-2, 5:], axis=0)) == 1


def test_path_within_one_cell_is_the_goal_pose():
    costmap, cells = _costmap(), np.array([(3, 4)], np.int32)
    start, goal = _ends(costmap, cells)
    assert path_poses(costmap, cells, start, goal).tolist() == [
        [goal.x, goal.y, 0.0, 0.0, 0.0, math.sin(-1.0), math.cos(-1.0)]
    ]
    assert path_cost(costmap, cells) == 0.0


def test_a_path_through_centres_has_the_same_poses_by_points():
    costmap, cells = _costmap(), _walk(2, 30)
    ends = _ends(costmap, cells)
    poses, through = path_poses(costmap, cells, *ends), poses_through(costmap, cells.astype(np.float64), *ends)
    assert through[:, :2] == pytest.approx(poses[:, :2])
    assert path_length(through) == pytest.approx(path_length(poses))


A, B, C = Pose2D(1.0, 1.0, 0.0), Pose2D(4.0, 3.0, 1.0), Pose2D(1.0, 3.0, 2.0)
COSTMAP = build_layers(walled_map(6, 4, [])).costmap


def plan(request: PlanRequest):
    return planners.create("dijkstra").plan(COSTMAP, request)


def test_without_poses_between_it_is_the_plan_to_the_goal():
    assert plan_through(plan, (), PlanRequest(A, B)).cost == plan(PlanRequest(A, B)).cost


def test_parts_are_joined_without_repeating_the_poses_between_them():
    joined = plan_through(plan, (B,), PlanRequest(A, C))
    first, second = plan(PlanRequest(A, B)), plan(PlanRequest(B, C))
    assert len(joined.poses) == len(first.poses) + len(second.poses) - 1 == len(joined.cells)
    assert (joined.cost, joined.length) == pytest.approx((first.cost + second.cost, first.length + second.length))
    assert np.abs(np.diff(joined.cells, axis=0)).max() == 1
    assert joined.id == joined.reused == ""


def test_an_error_names_the_pose_that_is_not_reached():
    with pytest.raises(GoalOutsideMap, match=r"^pose 2 of 3: "):
        plan_through(plan, (B, Pose2D(40.0, 0.0, 0.0)), PlanRequest(A, C))


def test_the_time_limit_is_that_of_all_parts_together():
    now = [0.0]

    def slow(request: PlanRequest):
        assert request.timeout == pytest.approx(5.0 - now[0])
        now[0] += 3.0
        return plan(request)

    with pytest.raises(PlanTimeout, match=r"pose 3 of 3: no path within 5 s"):
        plan_through(slow, (B, A), PlanRequest(A, C, timeout=5.0, clock=lambda: now[0]))


numbers = (
    st.floats(-1e9, 1e9)
    | st.floats(-1e-8, 1e-8)
    | st.floats(-MAX_MAGNITUDE, MAX_MAGNITUDE, exclude_min=True, exclude_max=True)
)
few = st.sampled_from([0.0, -0.0, 1.0, -12.75])
"""Few numbers, so that rows often end like the previous row."""

numbers = numbers | few
tables = st.integers(1, 4).flatmap(
    lambda m: st.lists(st.lists(numbers, min_size=m, max_size=m) | st.lists(few, min_size=m, max_size=m), min_size=1)
)
POSES = np.array(
    [[1.25, -2.5, 0.0, 0.0, 0.0, math.sin(0.4), math.cos(0.4)], [1e6 / 3, -1e-10, 0.0, 0.0, 0.0, -1.0, 0.0]]
)


def written(rows: list[list[float]], pieces: list[str]) -> str:
    each = [piece.encode() for piece in pieces]
    joined = b"".join(each)
    text = np.zeros(len(rows) * (len(joined) + len(rows[0]) * WIDEST) + TEXT_BLOCK, np.uint8)
    template = np.frombuffer(joined + bytes(TEXT_BLOCK), np.uint8)
    ends = np.cumsum([len(piece) for piece in each]).astype(np.uint64)
    return text[: int(write_rows(np.array(rows), template, ends, text))].tobytes().decode()


@given(tables, st.lists(st.text("[]{},:x", max_size=20), min_size=5, max_size=5))
def test_kernel_writes_like_its_twin(rows: list[list[float]], pieces: list[str]) -> None:
    used = pieces[: len(rows[0]) + 1]
    assert written(rows, used) == twin.rows_text(rows, used)


@given(st.lists(st.lists(st.floats(-1e6, 1e6), min_size=7, max_size=7)))
def test_numbers_round_trip_within_half_a_billionth(rows: list[list[float]]) -> None:
    read = json.loads(rows_text(np.array(rows).reshape(-1, 7)))
    assert len(read) == len(rows)
    np.testing.assert_allclose(np.array(read).reshape(-1, 7), np.array(rows).reshape(-1, 7), rtol=0.0, atol=6e-10)


def test_trailing_zeros_are_omitted() -> None:
    assert json.loads(rows_text(POSES)) == [
        [1.25, -2.5, 0.0, 0.0, 0.0, 0.389418342, 0.921060994],
        [333333.333333333, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0],
    ]
    assert rows_text(POSES[:1]).startswith("[[1.25,-2.5,0.0,0.0,")


def test_path_message_has_ros_form_and_a_header_per_pose() -> None:
    header = Header(7, Time(3, 4), 'the "map"')
    path = decode(Path, encode(path_message(POSES, header)))
    assert path.header == header
    assert [pose.header for pose in path.poses] == [header, header]
    pose = path.poses[0].pose
    assert (pose.position.x, pose.position.y, pose.position.z) == (1.25, -2.5, 0.0)
    assert (pose.orientation.x, pose.orientation.y) == (0.0, 0.0)
    assert (pose.orientation.z, pose.orientation.w) == (0.389418342, 0.921060994)


def test_no_poses_are_an_empty_list() -> None:
    none = np.empty((0, 7))
    assert rows_text(none) == "[]"
    assert decode(Path, encode(path_message(none, Header()))).poses == []


@pytest.mark.parametrize("number", [math.nan, math.inf, -math.inf, MAX_MAGNITUDE, -1e300])
def test_a_number_out_of_range_is_refused(number: float) -> None:
    poses = POSES.copy()
    poses[1, 1] = number
    with pytest.raises(InvalidInput, match="nearer"):
        rows_text(poses)
