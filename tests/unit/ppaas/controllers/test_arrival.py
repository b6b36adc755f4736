import math

import numpy as np
import pytest

from ppaas.controllers.arrival import ArrivalDetector, turn_by
from ppaas.controllers.base import Controller, ControlRequest, NoValidControl, Velocity
from ppaas.controllers.drive_parameters import body_of
from ppaas.controllers.dwa import DwaParameters, DynamicWindow
from ppaas.controllers.mppi import PathIntegral
from ppaas.controllers.pure_pursuit import PurePursuit
from ppaas.costmap.costmap import Costmap
from ppaas.footprints import Footprint
from ppaas.geometry import Pose2D, wrap_angle
from tests.reference.driving.controllers import outline_distance
from tests.support.world import grids
from tests.support.world.driving import Unicycle, along_x

PARAMETERS = DwaParameters()
GOAL = Pose2D(2.0, 1.0, math.pi / 2)
LONG = ((0.5, 0.12), (-0.15, 0.12), (-0.15, -0.12), (0.5, -0.12))
STANDING = Velocity()


def arrival_of(footprint: Footprint = ()) -> ArrivalDetector:
    return ArrivalDetector(PARAMETERS, body_of(footprint, PARAMETERS.robot_radius))


def settle(
    arrival: ArrivalDetector, pose: Pose2D, velocity: Velocity = STANDING, posts: tuple[Pose2D, ...] = ()
) -> Velocity:
    return arrival.settle(ControlRequest(pose, velocity, costmap_with(posts)), GOAL, velocity)


def costmap_with(posts: tuple[Pose2D, ...]) -> Costmap:
    data = np.zeros((40, 80), np.uint8)
    for post in posts:
        data[round(post.y / 0.05 - 0.5), round(post.x / 0.05 - 0.5)] = 254
    return grids.of(data, 0.05)


def test_robot_arrives_well_within_tolerance_or_beside_the_goal():
    well_within, in_front, beside, far = (
        Pose2D(1.96, 1.0), Pose2D(1.92, 1.0), Pose2D(1.92, 1.0, 2.0), Pose2D(1.8, 1.0),
    )  # fmt: skip
    for pose, there in ((well_within, True), (in_front, False), (beside, True), (far, False)):
        assert arrival_of().arrive(pose, GOAL) is there


def test_arrival_holds_within_twice_the_tolerance_until_a_new_goal():
    arrival = arrival_of()
    assert arrival.head_for(GOAL)
    assert arrival.arrive(Pose2D(1.97, 1.0), GOAL)
    assert not arrival.head_for(GOAL)
    assert arrival.arrive(Pose2D(1.85, 1.0), GOAL)
    assert arrival.head_for(Pose2D(2.0, 1.0, 0.0))
    assert not arrival.arrive(Pose2D(1.85, 1.0), GOAL)


def test_goal_is_reached_at_rest_at_position_and_heading():
    arrival = arrival_of()
    assert arrival.is_reached(Pose2D(1.95, 1.0, 1.5), Velocity(), GOAL)
    assert not arrival.is_reached(Pose2D(1.95, 1.0, 1.5), Velocity(0.3, 0.0), GOAL)
    assert not arrival.is_reached(Pose2D(1.95, 1.0, 0.5), Velocity(), GOAL)
    assert not arrival.is_reached(Pose2D(1.5, 1.0, 1.5), Velocity(), GOAL)


def test_robot_stops_before_it_turns():
    arrival = arrival_of()
    assert settle(arrival, Pose2D(2.0, 1.0), Velocity(0.3, 0.0)) == pytest.approx((0.2, 0.0))
    assert settle(arrival, Pose2D(2.0, 1.0)).angular > 0.0
    assert settle(arrival, Pose2D(2.0, 1.0, math.pi / 2)) == (0.0, 0.0)


def test_robot_facing_backwards_keeps_its_turning_direction():
    assert turn_by(-3.1, Velocity(0.0, 0.5), PARAMETERS, 0.1).angular > 0.0
    assert turn_by(-2.0, Velocity(0.0, 0.2), PARAMETERS, 0.1).angular < 0.2


AHEAD_LEFT, AHEAD_RIGHT = Pose2D(2.325, 1.325), Pose2D(2.325, 0.675)
"""Posts that the corners of a long robot would touch as it turns to that side; the other side is free."""


def test_robot_turns_the_long_way_if_the_short_one_is_blocked():
    for posts, side in (((), 1.0), ((AHEAD_LEFT,), -1.0)):
        assert settle(arrival_of(LONG), Pose2D(2.0, 1.0), posts=posts).angular * side > 0.0
    assert settle(arrival_of(), Pose2D(2.0, 1.0), posts=(AHEAD_LEFT,)).angular > 0.0


def test_no_space_to_turn_raises_no_valid_control():
    with pytest.raises(NoValidControl, match="room"):
        settle(arrival_of(LONG), Pose2D(2.0, 1.0), posts=(AHEAD_LEFT, AHEAD_RIGHT))


def test_turning_direction_is_kept_until_a_new_goal():
    arrival, turned = arrival_of(LONG), Pose2D(2.0, 1.0, -0.6)
    settle(arrival, Pose2D(2.0, 1.0), posts=(AHEAD_LEFT,))
    assert settle(arrival, turned, Velocity(0.0, -0.5)).angular < 0.0
    arrival.head_for(GOAL)
    assert settle(arrival, turned).angular > 0.0


@pytest.mark.parametrize("kind", [DynamicWindow, PathIntegral, PurePursuit])
@pytest.mark.parametrize("post", [AHEAD_LEFT, AHEAD_RIGHT])
def test_corners_touch_nothing_while_turning_to_the_goal_heading(kind, post):
    controller: Controller = kind(footprint=LONG, robot_radius=0.52)
    theta = math.pi / 2 if post is AHEAD_LEFT else -math.pi / 2
    controller.set_plan(along_x(1.98, 2.0, y=1.0, goal_theta=theta))
    robot, costmap = Unicycle(Pose2D(2.0, 1.0)), costmap_with((post,))
    least = math.inf
    for _ in range(120):
        if controller.is_goal_reached(robot.pose, robot.velocity):
            break
        command = controller.compute_velocity(ControlRequest(robot.pose, robot.velocity, costmap))
        for pose in robot.step(command, 0.1):
            least = min(least, outline_distance(costmap.data == 254, 0.05, np.array(LONG), pose))
    assert controller.is_goal_reached(robot.pose, robot.velocity)
    assert abs(wrap_angle(robot.pose.theta - theta)) <= PARAMETERS.yaw_goal_tolerance
    assert least >= 0.5 * 0.05
