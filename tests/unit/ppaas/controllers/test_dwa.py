"""The dynamic window approach: its parameters, rollouts and drives."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.drive_parameters import body_of
from ppaas.controllers.dwa import DwaParameters, DynamicWindow, Rollouts, window
from ppaas.controllers.followed_path import FollowedPath
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, poses_along, wrap_angle
from ppaas.parameters import read_parameters
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


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("max_vel_x", 0.0),
        ("max_vel_x", math.nan),
        ("acc_lim_x", -1.0),
        ("sim_time", math.inf),
        ("sim_time", "long"),
        ("sim_granularity", 0),
        ("vx_samples", 0),
        ("vth_samples", 2.5),
        ("xy_goal_tolerance", -0.1),
        ("max_vel_theta", True),
        ("allow_unknown", 1),
        ("min_vel_x", 0.6),
        ("min_vel_theta", 2.0),
        ("cost_slowdown", 1.0),
    ],
)
def test_invalid_parameters_are_refused_by_name(name, value):
    with pytest.raises(InvalidParameter, match=name):
        read_parameters(DwaParameters, "dwa", {name: value})


def test_integers_are_accepted_as_floats_and_reversing_is_allowed():
    parameters = read_parameters(DwaParameters, "dwa", {"max_vel_x": 1, "min_vel_x": -1})
    assert (parameters.max_vel_x, type(parameters.max_vel_x), parameters.min_vel_x) == (1.0, float, -1.0)


LIMITS = DwaParameters()
STANDING = Velocity()
PATH = poses_along(np.stack((np.arange(0.0, 4.0, 0.05), np.full(80, 1.0)), axis=1))


def rollouts(data, pose=Pose2D(1.0, 1.0), velocity=STANDING, **parameters):
    path = FollowedPath(PATH)
    path.locate(pose)
    request = ControlRequest(pose, velocity, grids.of(data, 0.05))
    p = DwaParameters(**parameters)
    return Rollouts(p, body_of(p.footprint, p.robot_radius), path, request, velocity)


def free_space():
    return np.zeros((40, 80), np.uint8)


def test_free_space_allows_full_acceleration_straight_ahead():
    assert rollouts(free_space()).best() == pytest.approx((0.1, 0.0))
    assert rollouts(free_space(), velocity=Velocity(0.45, 0.0)).best() == pytest.approx((0.5, 0.0))


def test_high_costs_reduce_the_speed():
    graded = np.full((40, 80), 200, np.uint8)
    assert rollouts(graded, velocity=Velocity(0.5, 0.0)).best().linear == pytest.approx(0.4)


def test_speed_is_reduced_near_the_goal():
    assert rollouts(free_space(), Pose2D(3.9, 1.0), Velocity(0.5, 0.0)).best().linear == pytest.approx(0.4)


def test_no_velocity_or_turn_is_found_close_to_a_wall():
    wall = free_space()
    wall[:, 21:] = 254
    facing = rollouts(wall, Pose2D(1.045, 1.0))
    assert facing.best() is None
    assert facing.turn_to_free(0.0) is None


def test_turn_to_free_finds_the_free_heading_at_a_slanted_wall():
    walls = np.fromfunction(lambda row, column: column > row, (40, 80))
    turn = rollouts(np.where(walls, 254, 0).astype(np.uint8)).turn_to_free(0.0)
    assert 0.6 < turn < 1.1


def test_turn_to_free_tries_headings_near_the_path_only():
    wall = free_space()
    wall[:, 21:] = 254
    near = rollouts(wall, Pose2D(1.03, 1.0))
    assert near.turn_to_free(0.0) is None
    assert 0.5 < near.turn_to_free(1.5) < 2.6


LONG = ((0.5, 0.12), (-0.5, 0.12), (-0.5, -0.12), (0.5, -0.12))


def test_footprint_drives_along_a_wall_but_cannot_turn_there():
    corridor = free_space()
    corridor[:16] = corridor[24:] = 254
    corridor[16:24] = 253
    beside = rollouts(corridor, velocity=Velocity(0.3, 0.0), footprint=LONG)
    assert beside.best().linear > 0.2
    assert not beside.can_turn(1.5)
    assert rollouts(corridor, velocity=Velocity(0.3, 0.0)).can_turn(1.5)
    assert rollouts(free_space(), footprint=LONG).can_turn(1.5)


@given(st.builds(Velocity, st.floats(0.0, 0.5), st.floats(-1.5, 1.5)), st.floats(0.0, 0.5), st.floats(0.02, 0.2))
def test_window_obeys_acceleration_and_velocity_limits(velocity, fastest, period):
    linear, angular = window(velocity, fastest, LIMITS, period).T
    reach = LIMITS.acc_lim_x * period
    slow = np.abs(linear) == LIMITS.min_vel_trans
    assert np.all((np.abs(linear - velocity.linear) <= reach + 1e-9) | slow)
    assert np.all(np.abs(angular - velocity.angular) <= LIMITS.acc_lim_theta * period + 1e-9)
    assert np.all((linear >= LIMITS.min_vel_trans) & (linear <= LIMITS.max_vel_x))
    assert np.all(np.abs(angular) <= LIMITS.max_vel_theta)
    assert linear.max() <= max(fastest, velocity.linear - reach, LIMITS.min_vel_trans) + 1e-9


def test_window_of_a_slow_base_has_the_minimum_speed_only():
    weak = DwaParameters(acc_lim_x=0.1)
    assert set(window(Velocity(), 0.5, weak, 0.1)[:, 0]) == {weak.min_vel_trans}


def test_window_includes_driving_straight():
    assert 0.0 in window(Velocity(0.2, 0.05), 0.5, LIMITS, 0.1)[:, 1]


def test_window_includes_reversing_only_if_allowed():
    assert window(Velocity(), 0.5, LIMITS, 0.1)[:, 0].min() > 0.0
    assert window(Velocity(), 0.5, DwaParameters(min_vel_x=-0.2), 0.1)[:, 0].min() == pytest.approx(-0.1)
