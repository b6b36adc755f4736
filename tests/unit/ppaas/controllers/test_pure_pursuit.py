"""Regulated pure pursuit: its parameters, the point that it steers towards, and drives."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.controllers.base import ControlRequest, NoValidControl, Velocity
from ppaas.controllers.pure_pursuit import (
    PurePursuit,
    PurePursuitParameters,
    carrot_at,
    curvature_to,
    legs_of,
    regulated_speed,
)
from ppaas.cost_values import FREE_SPACE, INSCRIBED_INFLATED_OBSTACLE, NO_INFORMATION
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, poses_along
from ppaas.parameters import read_parameters
from tests.reference.driving import controllers as twin
from tests.support.world import driving, grids
from tests.support.world.driving import (
    BOX,
    RADIUS,
    STANDING,
    Drive,
    Unicycle,
    World,
    along_x,
    assert_arrived,
    drive,
    gap,
    through_gap,
)

FIELD = World(np.zeros((80, 240), bool))


def travel(world: World, start: Pose2D, goal: Pose2D, seconds=60.0, period=0.1, **parameters) -> Drive:
    return driving.travel(PurePursuit(robot_radius=RADIUS, **parameters), world, start, goal, seconds, period)


def ask(controller, pose, costmap=FIELD.costmap, velocity=STANDING):
    return controller.compute_velocity(ControlRequest(pose, velocity, costmap, 0.1))


def test_robot_drives_at_full_speed_without_obstacles():
    result = travel(FIELD, Pose2D(1.0, 2.0), Pose2D(6.0, 2.0))
    assert result.reached
    assert result.seconds < 5.0 / 0.5 + 3.0


def test_robot_facing_away_turns_in_place_first_if_enabled():
    for turns in (True, False):
        controller = PurePursuit(use_rotate_to_heading=turns)
        controller.set_plan(along_x(1.0, 4.0, y=2.0))
        command = ask(controller, Pose2D(1.0, 2.0, 2.0))
        assert (command.linear == 0.0) is turns
        assert command.angular < 0.0


def test_turning_speed_obeys_the_lower_of_both_limits():
    for limit, most in ((0.5, 0.5), (9.0, 1.5)):
        controller = PurePursuit(rotate_to_heading_angular_vel=limit)
        controller.set_plan(along_x(1.0, 4.0, y=2.0))
        turning = 0.0
        for _ in range(8):
            turning = ask(controller, Pose2D(1.0, 2.0, 3.0), velocity=Velocity(0.0, turning)).angular
        assert abs(turning) == pytest.approx(most)


def test_robot_steers_along_the_arc_to_the_lookahead_point():
    controller = PurePursuit(lookahead_dist=1.0)
    controller.set_plan(along_x(1.0, 6.0, y=2.0))
    pose, velocity = Pose2D(2.0, 2.3), Velocity(0.5, 0.0)
    for _ in range(10):
        velocity = ask(controller, pose, velocity=velocity)
    # The arc through the robot, along its heading, to (2 + 0.954, 2): 2y / d².
    assert velocity.angular / velocity.linear == pytest.approx(-0.6, abs=0.01)


def test_fixed_curvature_lookahead_slows_down_earlier():
    corner = poses_along(np.array([(1.0, 2.0), (1.2, 2.0), (1.4, 2.0), (1.6, 2.0), (1.6, 2.4), (1.6, 3.0)]))
    speeds = []
    for fixed in (False, True):
        controller = PurePursuit(
            lookahead_dist=0.3, use_fixed_curvature_lookahead=fixed, curvature_lookahead_dist=1.0,
            regulated_linear_scaling_min_speed=0.0,
        )  # fmt: skip
        controller.set_plan(corner)
        velocity = STANDING
        for _ in range(10):
            velocity = ask(controller, Pose2D(1.0, 2.0), velocity=velocity)
        speeds.append(velocity.linear)
    assert speeds[1] < speeds[0] - 0.05


def test_robot_reverses_along_a_reversing_plan_if_allowed():
    there = np.stack((np.linspace(1.0, 3.0, 41), np.full(41, 2.0)), axis=1)
    back = np.stack((np.linspace(3.0, 1.5, 31), np.full(31, 2.0)), axis=1)[1:]
    controller = PurePursuit(allow_reversing=True, min_vel_x=-0.3)
    controller.set_plan(poses_along(np.concatenate((there, back)), 0.0))
    robot = Unicycle(Pose2D(1.0, 2.0))
    result = drive(FIELD, robot, controller, 40.0)
    assert_arrived(result, Pose2D(1.5, 2.0))
    commands = np.array(result.commands)
    assert commands[:, 0].max() == pytest.approx(0.5)
    assert commands[:, 0].min() == pytest.approx(-0.3)
    assert result.travelled == pytest.approx(3.5, abs=0.4)
    assert np.abs(np.diff(commands[:, 0])).max() <= 0.1 + 1e-9


def test_robot_turns_around_if_it_may_not_reverse():
    controller = PurePursuit(min_vel_x=-0.3)
    controller.set_plan(along_x(3.0, 1.0, y=2.0))
    assert ask(controller, Pose2D(3.0, 2.0)).linear == 0.0


def test_footprint_passes_a_gap_too_narrow_for_its_disc():
    for footprint, passes in ((BOX, True), ((), False)):
        controller = PurePursuit(robot_radius=0.4, footprint=footprint)
        assert (through_gap(controller, gap().costmap, 200)[-1] > 3.6) is passes


def test_robot_stops_before_a_wall_if_collision_detection_is_on():
    walls = np.zeros((80, 240), bool)
    walls[:, 100] = True
    walled = World(walls)
    for looks in (True, False):
        controller = PurePursuit(robot_radius=RADIUS, use_collision_detection=looks)
        controller.set_plan(along_x(3.0, 8.0, y=2.0))
        result = drive(walled, Unicycle(Pose2D(3.0, 2.0)), controller, 15.0)
        assert (result.stuck > 20) is looks
        assert (result.clearance > 0.0) is looks


def test_robot_touching_an_obstacle_may_only_drive_away_from_it():
    data = np.zeros((80, 80), np.uint8)
    data[40, 36] = 254
    costmap = grids.of(data, 0.05)
    for goal, moves in ((3.5, True), (0.5, False)):
        controller = PurePursuit(robot_radius=RADIUS)
        controller.set_plan(along_x(2.0, goal, y=2.025))
        pose = Pose2D(1.95, 2.025, 0.0 if moves else math.pi)
        if moves:
            assert ask(controller, pose, costmap).linear > 0.0
        else:
            with pytest.raises(NoValidControl, match="not free"):
                ask(controller, pose, costmap)


def test_unknown_cells_are_free_only_if_allowed():
    data = np.zeros((80, 80), np.uint8)
    data[:, 24:] = 255
    costmap = grids.of(data, 0.05)
    for allowed in (True, False):
        controller = PurePursuit(allow_unknown=allowed)
        controller.set_plan(along_x(1.0, 3.0, y=2.0))
        if allowed:
            assert ask(controller, Pose2D(1.0, 2.0), costmap).linear > 0.0
        else:
            with pytest.raises(NoValidControl):
                ask(controller, Pose2D(1.0, 2.0), costmap)


P = PurePursuitParameters(max_vel_x=0.5, max_vel_theta=9.0, acc_lim_x=9.0, robot_radius=0.2)
FAR = 10.0


def test_speed_on_a_straight_free_path_is_the_maximum():
    assert regulated_speed(P, 0.0, FREE_SPACE, FAR) == 0.5
    assert regulated_speed(P, 0.0, NO_INFORMATION, FAR) == 0.5


@pytest.mark.parametrize(("radius", "speed"), [(1.8, 0.5), (0.9, 0.5), (0.72, 0.4), (0.45, 0.25), (0.09, 0.25)])
def test_speed_in_a_curve_is_proportional_to_its_radius(radius, speed):
    for side in (1.0, -1.0):
        assert regulated_speed(P, side / radius, FREE_SPACE, FAR) == pytest.approx(speed)
    free = PurePursuitParameters(max_vel_theta=9.0, acc_lim_x=9.0, use_regulated_linear_velocity_scaling=False)
    assert regulated_speed(free, 1.0 / radius, FREE_SPACE, FAR) == 0.5


@pytest.mark.parametrize(("distance", "speed"), [(0.7, 0.5), (0.5, 0.5 * 0.5 / 0.6), (0.35, 0.5 * 0.35 / 0.6)])
def test_speed_near_an_obstacle_is_proportional_to_its_distance(distance, speed):
    cost = 252.0 * math.exp(-10.0 * (distance - 0.2))
    assert regulated_speed(P, 0.0, max(1, round(cost)), FAR) == pytest.approx(speed, rel=0.03)


def test_cost_regulation_keeps_the_minimum_speed():
    assert regulated_speed(P, 0.0, INSCRIBED_INFLATED_OBSTACLE, FAR) == 0.25
    blind = PurePursuitParameters(acc_lim_x=9.0, use_cost_regulated_linear_velocity_scaling=False)
    assert regulated_speed(blind, 0.0, INSCRIBED_INFLATED_OBSTACLE, FAR) == 0.5


@pytest.mark.parametrize(("to_go", "speed"), [(0.6, 0.5), (0.3, 0.25), (0.12, 0.1), (0.01, 0.05), (0.0, 0.05)])
def test_speed_near_the_goal_is_reduced_to_the_approach_minimum(to_go, speed):
    assert regulated_speed(P, 0.0, FREE_SPACE, to_go) == pytest.approx(speed)


@given(
    curvature=st.floats(-20.0, 20.0), cost=st.integers(0, 255), to_go=st.floats(0.0, 5.0),
    braking=st.floats(0.1, 3.0), turning=st.floats(0.3, 3.0),
)  # fmt: skip
def test_speed_never_exceeds_turning_braking_or_maximum_limits(curvature, cost, to_go, braking, turning):
    p = PurePursuitParameters(acc_lim_x=braking, max_vel_theta=turning)
    speed = regulated_speed(p, curvature, cost, to_go)
    assert 0.0 < speed <= p.max_vel_x
    assert speed * abs(curvature) <= turning * (1.0 + 1e-9)
    assert speed**2 <= max(braking * to_go, p.min_approach_linear_velocity**2) * (1.0 + 1e-9)


poses = st.builds(Pose2D, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3.1, 3.1))


@given(seed=st.integers(0, 10_000), pose=poses, distance=st.floats(0.1, 2.0))
def test_carrot_agrees_with_the_twin(seed, pose, distance):
    points = np.random.default_rng(seed).normal(0.15, 0.3, (12, 2)).cumsum(axis=0)
    x, y = twin.carrot(points, (pose.x, pose.y), distance)
    there = pose @ carrot_at(points, pose, distance)
    assert (there.x, there.y) == pytest.approx((x, y), abs=0.005)


@given(x=st.floats(-2.0, 2.0), y=st.floats(-2.0, 2.0))
def test_arc_is_tangent_to_the_heading_and_passes_the_point(x, y):
    curvature = curvature_to(Pose2D(x, y))
    if abs(curvature) < 1e-6:
        assert abs(y) < 1e-5
    else:
        radius = 1.0 / curvature
        assert math.hypot(x, y - radius) == pytest.approx(abs(radius), rel=1e-6)


def test_plan_is_split_where_it_reverses():
    x = np.array([0.0, 1.0, 2.0, 2.0, 1.0, 0.5, 1.5])
    plan = poses_along(np.stack((x, np.zeros(7)), axis=1), 1.0)
    legs = legs_of(plan)
    assert [leg[[0, -1], 0].tolist() for leg in legs] == [[0.0, 2.0], [2.0, 0.5], [0.5, 1.5]]
    assert (legs[-1][-1] == plan[-1]).all()
    assert sum(len(leg) for leg in legs) == len(plan) + 2


@pytest.mark.parametrize("points", [[(1.0, 2.0)], [(1.0, 2.0)] * 3, [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]])
def test_plan_without_reversals_is_one_leg(points):
    plan = poses_along(np.array(points))
    (leg,) = legs_of(plan)
    assert (leg == plan).all()


@pytest.mark.parametrize(
    ("wrong", "named"),
    [
        ({"lookahead_dist": 0.0}, "lookahead_dist"),
        ({"lookahead_time": math.nan}, "lookahead_time"),
        ({"min_lookahead_dist": 1.0}, "min_lookahead_dist"),
        ({"cost_scaling_gain": 1.5}, "cost_scaling_gain"),
        ({"rotate_to_heading_angular_vel": 0.1}, "rotate_to_heading_angular_vel"),
        ({"regulated_linear_scaling_min_radius": 0}, "regulated_linear_scaling_min_radius"),
        ({"use_rotate_to_heading": 1}, "use_rotate_to_heading"),
        ({"allow_reversing": True}, "min_vel_x below 0"),
        ({"footprint": [[0.1, 0.1]]}, "footprint"),
        ({"max_allowed_time_to_collision_up_to_carrot": -1.0}, "max_allowed_time_to_collision_up_to_carrot"),
    ],
)
def test_invalid_parameters_are_refused_by_name(wrong, named):
    with pytest.raises(InvalidParameter, match=named):
        read_parameters(PurePursuitParameters, "pure_pursuit", wrong)


def test_reversing_is_valid_with_a_negative_min_vel_x():
    assert PurePursuitParameters(allow_reversing=True, min_vel_x=-0.2).allow_reversing
