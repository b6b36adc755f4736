"""Paths through several poses."""

import numpy as np
import pytest

from ppaas import planners
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import GoalOutsideMap, PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.through_poses import plan_through
from tests.support.world.planar_world import walled_map

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
