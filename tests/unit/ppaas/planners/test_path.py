import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas import planners
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOutsideMap, PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo
from ppaas.planners.base import PlanRequest
from ppaas.planners.kernels.path_poses import BLOCK
from ppaas.planners.path import FEW, path_cost, path_length, path_poses, poses_through
from ppaas.planners.through_poses import plan_through
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
