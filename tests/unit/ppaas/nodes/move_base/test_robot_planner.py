"""Plans of the robot: errors that are final, and errors that are not."""

import numpy as np
import pytest

from ppaas import planners
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.errors import GoalOccupied, GoalOutsideMap, NoValidPath, PlanTimeout, StartOccupied, StartOutsideMap
from ppaas.geometry import Pose2D
from ppaas.nodes.move_base.robot_planner import NoPlan, plan_for_robot
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.plans.reuse.setup import ReuseSetup
from tests.support.world.planar_world import walled_map

STATIC = build_layers(walled_map(4, 3, [(1.9, 0.0, 2.1, 1.0)])).costmap
ENCLOSED = build_layers(walled_map(4, 3, [(1.9, 0.0, 2.1, 3.0)])).costmap
LEFT, RIGHT, IN_WALL = Pose2D(1.0, 1.5, 0.0), Pose2D(3.0, 1.5, 0.0), Pose2D(2.0, 0.5, 0.0)


def plan(start, goal, current=STATIC, static=STATIC, **fields):
    processor, request = ReuseSetup().processor(static, 0.18), PlanRequest(start, goal, **fields)
    return plan_for_robot(processor, planners.create("dijkstra"), static, current, request, reuse=True)


def covered(x0: float, x1: float) -> Costmap:
    data = STATIC.data.copy()
    data[:, round(x0 / 0.05) : round(x1 / 0.05)] = 254
    return Costmap(data, STATIC.info)


def test_free_path_is_planned():
    assert isinstance(plan(LEFT, RIGHT), PlanResult)


def test_path_blocked_by_a_seen_obstacle_is_not_final():
    found = plan(LEFT, RIGHT, current=covered(1.9, 2.1))
    assert isinstance(found, NoPlan)
    assert isinstance(found.error, NoValidPath)
    assert not found.final


def test_goal_occupied_by_a_seen_obstacle_is_not_final():
    found = plan(LEFT, RIGHT, current=covered(2.7, 3.3))
    assert isinstance(found, NoPlan)
    assert isinstance(found.error, GoalOccupied)
    assert not found.final


@pytest.mark.parametrize("current", [ENCLOSED, Costmap(np.maximum(ENCLOSED.data, 1), ENCLOSED.info)])
def test_path_blocked_by_the_map_is_final(current):
    found = plan(LEFT, RIGHT, current=current, static=ENCLOSED)
    assert isinstance(found, NoPlan)
    assert isinstance(found.error, NoValidPath)
    assert found.final


@pytest.mark.parametrize(
    ("start", "goal", "error"),
    [
        (LEFT, IN_WALL, GoalOccupied),
        (LEFT, Pose2D(99, 0, 0), GoalOutsideMap),
        (Pose2D(-9, 0, 0), RIGHT, StartOutsideMap),
    ],
)
def test_goal_and_start_errors_of_the_map_are_final(start, goal, error):
    found = plan(start, goal)
    assert isinstance(found, NoPlan)
    assert isinstance(found.error, error)
    assert found.final


@pytest.mark.parametrize(
    ("start", "fields", "error"), [(IN_WALL, {}, StartOccupied), (LEFT, {"timeout": 0.0}, PlanTimeout)]
)
def test_occupied_start_and_timeout_are_not_final(start, fields, error):
    found = plan(start, RIGHT, **fields)
    assert isinstance(found, NoPlan)
    assert isinstance(found.error, error)
    assert not found.final
