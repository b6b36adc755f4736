import math

import numpy as np
import pytest

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.dwa import DynamicWindow
from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, poses_along, wrap_angle
from ppaas.planners.base import PlanRequest
from ppaas.planners.dijkstra import Dijkstra
from tests.support import grids, worlds
from tests.support.driving import RADIUS, Drive, Unicycle, World, drive

OPEN = """
    ##########
    #........#
    #........#
    #........#
    ##########
"""


def along_x(first, last, y=1.2, goal_theta=0.0):
    x = np.linspace(first, last, 2 + round(abs(last - first) / 0.05))
    return poses_along(np.stack((x, np.full_like(x, y)), axis=1), goal_theta)


def travel(world: World, start: Pose2D, goal: Pose2D, seconds=60.0, period=0.1, **parameters) -> Drive:
    controller = DynamicWindow(robot_radius=RADIUS, **parameters)
    controller.set_plan(Dijkstra().plan(world.costmap, PlanRequest(start, goal)).poses)
    return drive(world, Unicycle(start), controller, seconds, period)


def assert_arrived(result: Drive, goal: Pose2D) -> None:
    assert result.reached
    assert result.clearance > 0.0
    assert result.end.distance_to(goal) <= 0.2
    assert abs(wrap_angle(result.end.theta - goal.theta)) <= 0.15


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("draw", [worlds.rooms, worlds.pillars])
def test_it_reaches_the_goal_and_touches_nothing(draw, seed):
    world = draw(seed)
    start, goal, plan = worlds.journey(world, seed)
    controller = DynamicWindow(robot_radius=RADIUS)
    controller.set_plan(plan.poses)
    result = drive(world, Unicycle(start), controller, 20.0 + 10.0 * plan.length)
    assert_arrived(result, goal)
    assert result.travelled <= 1.2 * plan.length + 0.3


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("period", "parameters"), [(0.05, {}), (0.1, {"max_vel_x": 1.0}), (0.2, {"acc_lim_x": 0.4})])
def test_it_does_so_at_other_rates_and_limits(seed, period, parameters):
    world = worlds.rooms(100 + seed)
    start, goal, plan = worlds.journey(world, seed)
    controller = DynamicWindow(robot_radius=RADIUS, **parameters)
    controller.set_plan(plan.poses)
    assert_arrived(drive(world, Unicycle(start), controller, 20.0 + 10.0 * plan.length, period), goal)


def test_commands_keep_the_limits_of_speed_and_acceleration():
    world = worlds.picture(OPEN)
    result = travel(world, Pose2D(0.8, 1.0, 2.0), Pose2D(3.2, 1.4, -1.0))
    commands = np.array([(0.0, 0.0), *result.commands])
    steps = np.abs(np.diff(commands, axis=0))
    assert np.all(steps[:, 0] <= 0.1 + 1e-9)
    assert np.all(steps[:, 1] <= max(0.3, 2 * 0.2) + 1e-9)
    assert np.all(commands[:, 0] <= 0.5)
    assert commands[:, 0].max() == pytest.approx(0.5)
    assert np.all(np.abs(commands[:, 1]) <= 1.5)


def test_it_drives_at_full_speed_where_nothing_is_near():
    world = World(np.zeros((80, 240), bool))
    result = travel(world, Pose2D(1.0, 2.0), Pose2D(11.0, 2.0))
    assert result.reached
    assert result.seconds < 10.0 / 0.5 + 3.0


def test_it_is_slower_in_a_narrow_passage():
    passage = "####################\n....................\n####################"
    narrow, wide = worlds.picture(passage, 12), worlds.picture(passage, 40)
    seconds = [
        travel(world, Pose2D(1.0, y), Pose2D(8.0, y)).seconds for world, y in ((narrow, 12 * 0.075), (wide, 3.0))
    ]
    assert seconds[0] > 1.15 * seconds[1]


def test_facing_away_it_turns_on_the_spot_first():
    world = worlds.picture(OPEN)
    controller = DynamicWindow()
    controller.set_plan(along_x(0.8, 3.0))
    robot = Unicycle(Pose2D(0.8, 1.2, math.pi))
    for _ in range(8):
        command = controller.compute_velocity(ControlRequest(robot.pose, robot.velocity, world.costmap))
        assert command.linear == 0.0
        assert abs(command.angular) >= 0.2
        list(robot.step(command, 0.1))
    assert robot.pose.distance_to(Pose2D(0.8, 1.2)) < 1e-9


@pytest.mark.parametrize("wobble", [0.05, -0.05])
def test_facing_away_it_keeps_to_the_side_it_began_with(wobble):
    world = worlds.picture(OPEN)
    controller = DynamicWindow()
    controller.set_plan(along_x(0.8, 3.0))
    robot = Unicycle(Pose2D(0.8, 1.2, math.pi - 0.02))
    signs = set()
    for cycle in range(12):
        noisy = robot.pose._replace(theta=robot.pose.theta + wobble * (-1) ** cycle)
        command = controller.compute_velocity(ControlRequest(noisy, robot.velocity, world.costmap))
        signs.add(math.copysign(1.0, command.angular))
        list(robot.step(command, 0.1))
    assert len(signs) == 1


def test_at_the_goal_it_stops_then_turns_to_the_heading_asked_for():
    world = worlds.picture(OPEN)
    result = travel(world, Pose2D(1.0, 1.2), Pose2D(2.0, 1.2, math.pi / 2))
    assert result.reached
    assert abs(wrap_angle(result.end.theta - math.pi / 2)) <= 0.15
    assert result.end.distance_to(Pose2D(2.0, 1.2)) <= 0.1


def test_a_goal_under_its_wheels_asks_for_a_turn_alone():
    world = worlds.picture(OPEN)
    result = travel(world, Pose2D(1.0, 1.2), Pose2D(1.02, 1.2, 3.0))
    assert result.reached
    assert result.travelled < 1e-9


def test_once_there_a_push_within_twice_the_tolerance_does_not_send_it_back():
    world = worlds.picture(OPEN)
    controller = DynamicWindow()
    controller.set_plan(along_x(1.0, 2.0, goal_theta=math.pi / 2))

    def ask(x):
        return controller.compute_velocity(ControlRequest(Pose2D(x, 1.2), Velocity(), world.costmap))

    assert ask(1.98).linear == 0.0
    controller.set_plan(along_x(1.5, 2.0, goal_theta=math.pi / 2))
    assert ask(1.85).linear == 0.0
    assert controller.is_goal_reached(Pose2D(1.85, 1.2, math.pi / 2), Velocity())
    assert ask(1.75).linear > 0.0
    assert not controller.is_goal_reached(Pose2D(1.85, 1.2, math.pi / 2), Velocity())


def test_the_goal_is_not_reached_while_it_moves_or_faces_elsewhere():
    controller = DynamicWindow()
    controller.set_plan(along_x(1.0, 2.0, goal_theta=1.0))
    assert controller.is_goal_reached(Pose2D(1.95, 1.2, 1.1), Velocity(0.05, 0.05))
    assert not controller.is_goal_reached(Pose2D(1.95, 1.2, 1.1), Velocity(0.2, 0.0))
    assert not controller.is_goal_reached(Pose2D(1.95, 1.2, 1.1), Velocity(0.0, 0.2))
    assert not controller.is_goal_reached(Pose2D(1.95, 1.2, 1.2), Velocity())
    assert not controller.is_goal_reached(Pose2D(1.85, 1.2, 1.0), Velocity())


def test_before_a_wall_that_the_plan_does_not_know_it_stops_and_says_so():
    world = worlds.picture("####################\n....................\n####################", 16)
    blocked = world.walls.copy()
    blocked[:, 160:164] = True
    blocked = World(blocked)
    controller = DynamicWindow()
    controller.set_plan(Dijkstra().plan(world.costmap, PlanRequest(Pose2D(1.0, 1.2), Pose2D(14.0, 1.2))).poses)
    result = drive(blocked, Unicycle(Pose2D(1.0, 1.2)), controller, 40.0)
    assert not result.reached
    assert result.clearance > 0.0
    assert result.end.x > 6.5
    assert result.stuck > 50
    with pytest.raises(NoValidControl, match="recover"):
        controller.compute_velocity(ControlRequest(result.end, Velocity(), blocked.costmap))


def test_standing_in_an_obstacle_no_velocity_is_valid():
    controller = DynamicWindow()
    controller.set_plan(along_x(0.5, 2.0))
    walls = grids.of(np.full((60, 60), 254, np.uint8), 0.05)
    with pytest.raises(NoValidControl):
        controller.compute_velocity(ControlRequest(Pose2D(0.5, 1.2), Velocity(), walls))


def test_a_robot_pushed_into_an_inscribed_cell_drives_out():
    world = worlds.picture(OPEN)
    start = Pose2D(0.4 + RADIUS + 0.01, 1.2, 0.3)
    assert world.costmap.data[world.costmap.info.cell_of(start.x, start.y)] == 253
    assert_arrived(travel(world, start, Pose2D(2.5, 1.2)), Pose2D(2.5, 1.2))


def test_odometry_that_no_command_explains_is_believed():
    controller = DynamicWindow()
    controller.set_plan(along_x(0.5, 3.0))
    open_ground = grids.of(np.zeros((60, 100), np.uint8), 0.05)
    command = controller.compute_velocity(ControlRequest(Pose2D(0.5, 1.2), Velocity(0.45, 0.0), open_ground))
    assert command.linear >= 0.45


@pytest.mark.parametrize(
    ("pose", "velocity", "period"),
    [
        (Pose2D(math.nan, 1.0), Velocity(), 0.1),
        (Pose2D(0.5, 1.0), Velocity(math.inf, 0.0), 0.1),
        (Pose2D(0.5, 1.0), Velocity(), 0.0),
        (Pose2D(0.5, 1.0), Velocity(), math.nan),
    ],
)
def test_what_is_not_finite_is_refused(pose, velocity, period):
    controller = DynamicWindow()
    controller.set_plan(along_x(0.5, 2.0))
    with pytest.raises(InvalidInput):
        controller.compute_velocity(ControlRequest(pose, velocity, worlds.picture(OPEN).costmap, period))


def test_without_a_plan_it_asks_for_one():
    with pytest.raises(InvalidInput, match="set_plan"):
        DynamicWindow().is_goal_reached(Pose2D(0.0, 0.0), Velocity())
