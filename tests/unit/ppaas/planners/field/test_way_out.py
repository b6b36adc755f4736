"""Plans of robots that are in a keep-out zone."""

from functools import partial

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.errors import GoalOccupied, StartOccupied
from ppaas.geometry import Pose2D
from ppaas.maps.grid import OCCUPIED
from ppaas.planners.base import PlanRequest, PlanResult
from ppaas.planners.field.way_out import plan_way_out
from ppaas.planners.grid.dijkstra import Dijkstra
from ppaas.zones.zone import KeepOut, ZoneSet
from tests.support.world.planar_world import walled_map
from tests.support.zones import rectangle

RADIUS = 0.2
GOAL = Pose2D(7.0, 4.0)


def planned(
    start: Pose2D, goal: Pose2D = GOAL, boxes: tuple[tuple[float, float, float, float], ...] = ()
) -> PlanResult:
    """Plan from a zone between (1, 1) and (5, 7) on a map of 8 × 8 m with some walls."""
    zone = rectangle(KeepOut(name="spill"), 1.0, 1.0, 5.0, 7.0)
    layers = build_layers(walled_map(8, 8, list(boxes)), robot_radius=RADIUS, zones=ZoneSet([zone]))
    local = LocalCostmap(layers, robot_radius=RADIUS)
    local.update(start)
    assert local.way_out is not None
    planner, request = Dijkstra(), PlanRequest(start, goal)
    found = plan_way_out(lambda part: planner.plan(layers.costmap, part), layers.costmap, local.way_out, request)
    assert layers.keepout is not None
    inside = layers.keepout.data[tuple(found.cells.T)] == OCCUPIED
    left = int(np.argmin(inside))
    assert not inside[left:].any(), "the path does not lead in again"
    assert (np.abs(np.diff(found.cells, axis=0)).max(axis=1) == 1).all()
    return found


@given(st.floats(1.3, 4.7), st.floats(1.3, 6.7))
def test_a_robot_leaves_by_the_nearest_side(x: float, y: float) -> None:
    found = planned(Pose2D(x, y))
    nearest = min(x - 1.0, 5.0 - x, y - 1.0, 7.0 - y)
    in_zone = found.poses[:, :2][((found.poses[:, :2] > (1.0, 1.0)) & (found.poses[:, :2] < (5.0, 7.0))).all(axis=1)]
    length = float(np.hypot(*np.diff(in_zone, axis=0).T).sum())
    assert length <= 1.1 * nearest + 0.2
    assert found.poses[0, :2] == pytest.approx((x, y))
    assert found.poses[-1, :2] == pytest.approx(GOAL[:2])


def test_walls_in_the_zone_are_driven_around() -> None:
    found = planned(Pose2D(4.5, 4.0), boxes=((4.8, 2.0, 4.9, 6.0),))
    assert found.length > 4.0
    assert found.id == ""


def test_a_robot_that_cannot_leave_is_told_so() -> None:
    walls = ((2.0, 2.0, 4.0, 2.1), (2.0, 4.0, 4.0, 4.1), (2.0, 2.0, 2.1, 4.1), (4.0, 2.0, 4.1, 4.1))
    with pytest.raises(StartOccupied, match=r"no way leads out of the keep-out zone 'spill' from x=3\.000 y=3\.000"):
        planned(Pose2D(3.0, 3.0), boxes=walls)


def test_a_robot_leaves_by_a_side_from_which_there_is_a_path() -> None:
    zone = rectangle(KeepOut(name="spill"), 2.0, 0.0, 5.0, 8.0)
    layers = build_layers(walled_map(8, 8, []), robot_radius=RADIUS, zones=ZoneSet([zone]))
    local, planner = LocalCostmap(layers, robot_radius=RADIUS), Dijkstra()
    start = Pose2D(2.5, 4.0)
    local.update(start)
    assert local.way_out is not None
    plan = partial(planner.plan, layers.costmap)
    found = plan_way_out(plan, layers.costmap, local.way_out, PlanRequest(start, GOAL))
    assert found.poses[:, 0].min() > 2.4
    assert found.poses[-1, :2] == pytest.approx(GOAL[:2])


def test_a_goal_in_the_zone_is_refused() -> None:
    with pytest.raises(GoalOccupied, match="is in the keep-out zone 'spill'"):
        planned(Pose2D(3.0, 3.0), Pose2D(3.0, 4.0))


def test_a_robot_outside_is_planned_as_usual() -> None:
    layers = build_layers(walled_map(8, 8, []), robot_radius=RADIUS)
    planner, request = Dijkstra(), PlanRequest(Pose2D(1.0, 1.0), GOAL)
    usual = planner.plan(layers.costmap, request)
    found = plan_way_out(lambda part: planner.plan(layers.costmap, part), layers.costmap, layers.costmap, request)
    np.testing.assert_array_equal(found.cells, usual.cells)
