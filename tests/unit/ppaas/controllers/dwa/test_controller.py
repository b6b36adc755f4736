import math

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.dwa import DynamicWindow
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.planners.base import PlanRequest
from ppaas.planners.grid.dijkstra import Dijkstra
from tests.support.world import driving, grids, worlds
from tests.support.world.driving import BOX, OPEN, RADIUS, Drive, Unicycle, World, along_x, drive, gap, through_gap


def travel(world: World, start: Pose2D, goal: Pose2D, seconds=60.0, period=0.1, **parameters) -> Drive:
    return driving.travel(DynamicWindow(robot_radius=RADIUS, **parameters), world, start, goal, seconds, period)


def test_robot_drives_at_full_speed_without_obstacles():
    world = World(np.zeros((80, 240), bool))
    result = travel(world, Pose2D(1.0, 2.0), Pose2D(11.0, 2.0))
    assert result.reached
    assert result.seconds < 10.0 / 0.5 + 3.0


def test_robot_facing_away_turns_in_place_first():
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
def test_robot_facing_away_keeps_its_turning_direction(wobble):
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


def test_robot_at_the_goal_turns_to_the_goal_heading():
    world = worlds.picture(OPEN)
    result = travel(world, Pose2D(1.0, 1.2), Pose2D(2.0, 1.2, math.pi / 2))
    assert result.reached
    assert abs(wrap_angle(result.end.theta - math.pi / 2)) <= 0.15
    assert result.end.distance_to(Pose2D(2.0, 1.2)) <= 0.1


def test_goal_at_the_robots_position_needs_a_turn_only():
    world = worlds.picture(OPEN)
    result = travel(world, Pose2D(1.0, 1.2), Pose2D(1.02, 1.2, 3.0))
    assert result.reached
    assert result.travelled < 1e-9


def test_arrived_robot_stays_within_twice_the_tolerance():
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


def test_goal_is_not_reached_while_moving_or_misaligned():
    controller = DynamicWindow()
    controller.set_plan(along_x(1.0, 2.0, goal_theta=1.0))
    assert controller.is_goal_reached(Pose2D(1.95, 1.2, 1.1), Velocity(0.05, 0.05))
    assert not controller.is_goal_reached(Pose2D(1.95, 1.2, 1.1), Velocity(0.2, 0.0))
    assert not controller.is_goal_reached(Pose2D(1.95, 1.2, 1.1), Velocity(0.0, 0.2))
    assert not controller.is_goal_reached(Pose2D(1.95, 1.2, 1.2), Velocity())
    assert not controller.is_goal_reached(Pose2D(1.85, 1.2, 1.0), Velocity())


def test_robot_stops_before_an_unplanned_wall():
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


def test_no_velocity_is_valid_inside_an_obstacle():
    controller = DynamicWindow()
    controller.set_plan(along_x(0.5, 2.0))
    walls = grids.of(np.full((60, 60), 254, np.uint8), 0.05)
    with pytest.raises(NoValidControl):
        controller.compute_velocity(ControlRequest(Pose2D(0.5, 1.2), Velocity(), walls))


def test_measured_velocity_is_used_without_previous_commands():
    controller = DynamicWindow()
    controller.set_plan(along_x(0.5, 3.0))
    free_space = grids.of(np.zeros((60, 100), np.uint8), 0.05)
    command = controller.compute_velocity(ControlRequest(Pose2D(0.5, 1.2), Velocity(0.45, 0.0), free_space))
    assert command.linear >= 0.45


def test_footprint_passes_a_gap_too_narrow_for_its_disc():
    walled, shut = gap(), gap().costmap
    shut.data[(shut.data < 253) & _within(walled.walls, 0.45)] = 253
    for footprint, costmap, passes in ((BOX, shut, True), ((), shut, False), ((), walled.costmap, True)):
        controller = DynamicWindow(robot_radius=0.4, footprint=footprint)
        assert (through_gap(controller, costmap, 150)[-1] > 3.6) is passes


def _within(cells, metres):
    return distance_transform_edt(~cells) * 0.05 <= metres
