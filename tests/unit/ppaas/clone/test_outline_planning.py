"""Robots that are longer than wide pass doors in which they cannot turn, as with costmap_2d's inscribed radius.

Others of the kind: a base whose origin is near its front, a goal in a narrow niche, a start in a door, a corner that is
too tight for the outline, a detour around a narrow door, and planners that prepare a map for the disc.
"""

import math
from itertools import pairwise

import numpy as np
import pytest

from ppaas.clock import ManualClock
from ppaas.clone.outline_planning import SHORTER, Outline, planner_of
from ppaas.clone.robot_body import robot_body
from ppaas.costmap import narrow_passages
from ppaas.costmap.build_layers import build_layers
from ppaas.costmap.costmap import Costmap
from ppaas.costmap.local_costmap import LocalCostmap
from ppaas.costmap.narrow_passages import NARROW, fits_along, with_narrow_passages
from ppaas.costmap.obstacle_layer import LaserReading
from ppaas.errors import GoalOccupied, NoValidPath, PlanCancelled, StartOccupied
from ppaas.geometry import Pose2D, poses_along
from ppaas.messages.actionlib_msgs import Status
from ppaas.planners.base import PlanRequest
from ppaas.planners.registry import PLANNERS
from ppaas.planners.watch import proceed
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, walled_map

OBLONG = [[0.5, 0.33], [-0.5, 0.33], [-0.5, -0.33], [0.5, -0.33]]
"""Half a metre before and behind the origin, a third beside it: the disc around it has a radius of 0.6 m."""

START, GOAL = Pose2D(1.5, 2.5), Pose2D(6.5, 2.5)


def body(footprint=OBLONG, **costmap):
    return robot_body("turtlebot2", None, {"global_costmap": {"footprint": footprint} | costmap})


def rooms(door: float, *, other: float = 0.0):
    """Return a map of two rooms with a door, and perhaps a wide one 4.5 m aside."""
    wall = [(3.9, 0.0, 4.1, 2.5 - door / 2), (3.9, 2.5 + door / 2, 4.1, 7.0 - other / 2)]
    return walled_map(8, 9, [*wall, (3.9, 7.0 + other / 2, 4.1, 9.0)])


def costmap(grid, robot) -> Costmap:
    return build_layers(grid, robot_radius=robot.robot_radius).costmap


def plan(name: str, grid, start=START, goal=GOAL, robot=None, **request):
    robot = robot or body()
    return planner_of(robot, name, {}).plan(costmap(grid, robot), PlanRequest(start, goal, **request))


@pytest.mark.parametrize("name", sorted({PLANNERS.own_name(each) for each in PLANNERS.names()}))
def test_every_planner_passes_a_door_in_which_the_robot_cannot_turn(name):
    result = plan(name, rooms(0.95))
    assert result.planner == name
    assert 5.0 <= result.length < 5.2
    assert result.seconds < 60.0
    assert fits_along(costmap(rooms(0.95), body()), result.poses, body().footprint)


def test_door_narrower_than_the_robot_is_no_way():
    with pytest.raises(NoValidPath):
        plan("dijkstra", rooms(0.6))


def test_path_on_which_the_robot_may_turn_is_preferred_unless_it_is_a_detour():
    wide = plan("dijkstra", rooms(2.0))
    assert 5.0 <= wide.length < 5.2
    around = plan("dijkstra", rooms(0.0, other=1.6))
    assert around.length > 8.0
    through = plan("dijkstra", rooms(0.95, other=1.6))
    assert through.length < SHORTER * around.length
    high, higher = Pose2D(1.5, 5.5), Pose2D(6.5, 5.5)
    assert plan("dijkstra", rooms(0.95, other=1.6), high, higher).poses[:, 1].min() > 4.5


def test_robot_in_a_door_goes_on_through_it():
    result = plan("dijkstra", rooms(0.95, other=1.6), start=Pose2D(4.0, 2.5))
    assert result.poses[:, 0].min() > 3.9
    assert result.length < 2.7


def test_goal_in_a_niche_is_taken_in_the_heading_in_which_the_robot_fits():
    niche = walled_map(8, 5, [(5.0, 0.0, 8.0, 2.0), (5.0, 2.9, 8.0, 5.0)])
    end = Pose2D(6.5, 2.45)
    assert plan("dijkstra", niche, goal=end).length < 5.2
    with pytest.raises(GoalOccupied):
        plan("dijkstra", niche, goal=Pose2D(end.x, end.y, math.pi / 2))
    back = plan("dijkstra", niche, goal=Pose2D(end.x, end.y, math.pi / 2), tolerance=2.0)
    assert back.poses[-1, 0] < 5.2


def test_corner_that_is_too_tight_for_the_outline_is_no_way():
    bend = walled_map(6, 6, [(0.0, 1.0, 3.6, 6.0), (4.5, 1.0, 6.0, 6.0), (4.5, 0.0, 6.0, 1.0)])
    with pytest.raises((NoValidPath, StartOccupied)):
        plan("dijkstra", bend, Pose2D(0.8, 0.55), Pose2D(4.05, 5.0, math.pi / 2))


def test_radius_of_the_robot_file_is_believed():
    assert body().inner_radius == pytest.approx(0.33)
    assert body(robot_radius=0.6).inner_radius is None
    with pytest.raises(NoValidPath):
        plan("dijkstra", rooms(0.95), robot=body(robot_radius=0.6))
    round_one = [[0.2 * math.cos(a), 0.2 * math.sin(a)] for a in np.linspace(0, 2 * math.pi, 24, endpoint=False)]
    assert body(round_one).inner_radius is None
    assert type(planner_of(body(round_one), "dijkstra", {})) is PLANNERS.load("dijkstra")


def test_twins_and_parameters_are_those_of_the_planner():
    planner = planner_of(body(), "dijkstra", {"allow_unknown": False})
    assert planner.twin().plan(costmap(rooms(0.95), body()), PlanRequest(START, GOAL)).length < 5.2
    assert (planner.name, planner.traits) == ("dijkstra", PLANNERS.load("dijkstra").traits)
    assert isinstance(planner, PLANNERS.load("dijkstra"))


def test_cancelling_ends_the_second_plan_too():
    asked = iter([False] * 3 + [True] * 1000)
    with pytest.raises(PlanCancelled):
        plan("astar", rooms(0.95), cancelled=lambda: next(asked))


@pytest.mark.parametrize(("took", "left"), [(4.0, [1.0]), (5.0, [])])
def test_both_plans_together_end_within_the_time_limit(took, left):
    clock, limits = ManualClock(), []
    tight = costmap(rooms(0.95), body())

    def usual(costmap, request):
        clock.advance(took)
        raise NoValidPath("the disc does not fit")

    def narrow(costmap, request):
        limits.append(request.timeout)
        clock.advance(0.5)
        return plan("dijkstra", rooms(0.95))

    outline = Outline(body().footprint, body().inner_radius)
    request = PlanRequest(START, GOAL, timeout=5.0, clock=clock)
    if left:
        assert outline.plan(usual, narrow, tight, request).seconds == took + 0.5
    else:
        with pytest.raises(NoValidPath):
            outline.plan(usual, narrow, tight, request)
    assert limits == left


def test_cells_of_narrow_passages_are_free_and_dear():
    tight = costmap(rooms(0.95), body())
    relaxed = with_narrow_passages(tight, 0.33)
    door = tight.info.cell_of(4.0, 2.5)
    assert (tight.data[door], relaxed.data[door]) == (253, NARROW)
    assert ((relaxed.data == NARROW) <= (tight.data == 253)).all()
    free = tight.data < 253
    assert (relaxed.data[free] == tight.data[free]).all()
    np.testing.assert_array_equal(relaxed.data == 254, tight.data == 254)


@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_outline_is_checked_along_a_path_on_any_map(turn):
    grid = rooms(0.95)
    info = type(grid.info)(grid.info.resolution, grid.info.width, grid.info.height, Pose2D(3.0, -1.0, turn))
    tight = Costmap(costmap(grid, body()).data, info)

    def along(*points: tuple[float, float]) -> bool:
        placed = np.array([(info.origin @ Pose2D(*point))[:2] for point in points])
        dense = np.concatenate([np.linspace(a, b, 60) for a, b in pairwise(placed)])
        return fits_along(tight, poses_along(dense), body().footprint)

    assert along((1.5, 2.5), (6.5, 2.5))
    assert not along((1.5, 2.5), (6.5, 2.8))
    assert not along((3.0, 1.5), (5.0, 3.5))
    assert along((1.5, 1.5), (2.5, 6.0))


def test_only_obstacles_near_the_path_are_examined(monkeypatch):
    """The rectangle around two doors at opposite ends of a map has all the obstacles of the map."""
    grid, wide = rooms(0.95), []
    near = narrow_passages._obstacles_near

    def noted(costmap, points, reach):
        wide.append(float(np.ptp(points, axis=0).max()) + 2.0 * reach)
        return near(costmap, points, reach)

    monkeypatch.setattr(narrow_passages, "_obstacles_near", noted)
    way = np.concatenate((np.linspace((1.5, 2.5), (7.4, 2.5), 240), np.linspace((7.4, 2.5), (7.4, 8.5), 240)))
    assert not fits_along(costmap(grid, body()), poses_along(way), body().footprint)
    assert fits_along(costmap(grid, body()), poses_along(way[:200]), body().footprint)
    assert len(wide) > 2
    assert max(wide) < 2.5


def test_obstacle_beside_the_robot_in_a_door_is_kept_and_its_own_parts_are_not():
    """The disc around the robot is not its body: something may stand in it beside the robot."""
    window = LocalCostmap(build_layers(rooms(2.0)), robot_radius=0.6, footprint=body().footprint)
    here = Pose2D(4.0, 2.5, math.pi / 2)
    beside = LaserReading(here, np.array([-math.pi / 2, 0.0]), np.array([0.45, 0.45]))
    costs = window.update(here, beside)
    right, ahead = costs.info.cell_of(4.45, 2.5), costs.info.cell_of(4.0, 2.95)
    assert (costs.data[right], costs.data[ahead] == 254) == (254, False)
    assert window.fits(here)
    assert not window.fits(Pose2D(4.0, 2.5, 0.0))
    assert LocalCostmap(build_layers(rooms(2.0))).fits(Pose2D(4.45, 2.5))


def test_wall_just_outside_the_window_is_not_a_narrow_passage():
    window = LocalCostmap(
        build_layers(walled_map(8, 5, [])),
        width=2.0, height=2.0, robot_radius=0.6, footprint=body().footprint, inner_radius=0.33,
    )  # fmt: skip
    costs = window.update(Pose2D(1.17, 2.5))
    assert costs.info.cell_of(0.175, 2.52)[1] == 0
    assert costs.data[20, :9].tolist() == [253] * 5 + [NARROW] * 4


def test_planner_that_replans_keeps_its_field_for_the_disc():
    """D* Lite repairs its last field: narrow passages must not change it with every plan."""
    planner, tight = planner_of(body(), "dstar_lite", {}), costmap(rooms(0.95, other=1.6), body())
    assert planner.plan(tight, PlanRequest(START, GOAL)).length < 5.2
    assert not len(planner._field.differing(tight, proceed))
    assert planner.plan(tight, PlanRequest(START, GOAL)).planner == "dstar_lite"
    assert planner.twin()._narrow is None


def test_local_planner_of_a_disc_is_not_led_through_a_narrow_door():
    """As a plug-in without a footprint, or one whose parameters say that the robot is a disc."""
    parameters = {"global_costmap": {"footprint": OBLONG}, "dwa": {"footprint": []}}
    driving = ClosedLoop(World(rooms(0.95), START), parameters=parameters)
    for _ in range(10):
        driving.step()
    driving.send_goal(GOAL)
    driving.run(120.0)
    assert driving.last_status() is Status.ABORTED
    assert driving.clearance > 0.6


@pytest.mark.parametrize("controller", ["dwa", "pure_pursuit", "mppi"])
def test_oblong_robot_is_driven_through_a_door(controller):
    world = World(rooms(0.95), START)
    footprint = {"global_costmap": {"footprint": OBLONG}}
    driving = ClosedLoop(world, parameters=footprint, base_local_planner=controller)
    for _ in range(10):
        driving.step()
    driving.send_goal(GOAL)
    driving.run(90.0)
    assert driving.results, driving.texts
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert driving.clearance > 0.36
