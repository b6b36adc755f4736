"""Local planners of a clone, configured for its body."""

import math

import pytest

from ppaas.clone.plugins import controller_of
from ppaas.clone.robot_body import robot_body
from ppaas.controllers.base import Controller, ControlRequest, Velocity
from ppaas.controllers.mppi import PathIntegral
from ppaas.controllers.registry import CONTROLLERS, controller_names
from ppaas.errors import InvalidParameter, NotFound
from ppaas.geometry import Pose2D, Poses
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.nav2_msgs import SpeedLimit
from ppaas.robot_model.known_models import RobotModel, robot_model
from tests.support.world.closed_loop import ClosedLoop
from tests.support.world.planar_world import World, error_of, walled_map

BOX = ((0.3, 0.2), (-0.3, 0.2), (-0.3, -0.2), (0.3, -0.2))
TURTLEBOT = robot_model("turtlebot2")
LONG = RobotModel("long", 0.37, TURTLEBOT.limits, footprint=BOX)
START = Pose2D(1.0, 1.0, math.pi / 2)
BEYOND = Pose2D(4.5, 1.6, 0.0)


@pytest.mark.parametrize("name", controller_names())
def test_local_planner_drives_a_robot_around_a_wall(name):
    world = World(walled_map(6, 5, [(2.9, 0.0, 3.1, 2.6)]), START, drift=1.0, seed=1)
    driving = ClosedLoop(world, base_local_planner=name)
    for _ in range(6):
        driving.step()
    driving.send_goal(BEYOND)
    driving.run(60.0)
    assert driving.last_status() is Status.SUCCEEDED, driving.results[-1].status.text
    assert error_of(world.pose, BEYOND)[0] < 0.2
    assert driving.clearance > 0.18
    assert max(abs(command.linear.x) for command in driving.commands) <= TURTLEBOT.limits.max_vel_x


@pytest.mark.parametrize("name", controller_names())
def test_local_planner_obeys_speed_limits_until_they_are_lifted(name):
    driving = ClosedLoop(World(walled_map(9, 3, []), Pose2D(1.0, 1.5)), base_local_planner=name)
    for _ in range(6):
        driving.step()
    driving.send_goal(Pose2D(8.0, 1.5, 0.0))
    fastest = []
    for limit in (SpeedLimit(0.0), SpeedLimit(0.3), SpeedLimit(30.0, percentage=True), SpeedLimit(0.0)):
        driving.graph.inject("speed_limit", limit)
        driving.run(1.5)
        del driving.commands[:-10]
        fastest.append(max(command.linear.x for command in driving.commands))
    assert fastest[0] == pytest.approx(0.65, abs=0.03)
    assert 0.2 < fastest[1] <= 0.3 + 1e-9
    assert 0.1 < fastest[2] <= 0.3 * 0.65 + 1e-9
    assert fastest[3] == pytest.approx(0.65, abs=0.03)


@pytest.mark.parametrize("name", controller_names())
def test_local_planner_takes_limits_from_the_body_by_default(name):
    assert controller_of(TURTLEBOT, name, {}).parameters.max_vel_x == 0.65
    assert controller_of(TURTLEBOT, name, {"max_vel_x": 0.3}).parameters.max_vel_x == 0.3
    assert controller_of(LONG, name, {}).parameters.robot_radius == 0.37


def test_mppi_takes_the_footprint_of_the_body_by_default():
    controller = controller_of(LONG, "nav2_mppi_controller::MPPIController", {})
    assert isinstance(controller, PathIntegral)
    assert controller.parameters.footprint == BOX
    assert controller_of(LONG, "mppi", {"footprint": ()}).parameters.footprint == ()
    assert controller_of(TURTLEBOT, "mppi", {}).parameters.footprint == ()


def test_unknown_planners_and_parameters_are_refused():
    with pytest.raises(NotFound):
        controller_of(TURTLEBOT, "hands", {})
    with pytest.raises(InvalidParameter, match="horn"):
        controller_of(TURTLEBOT, "mppi", {"horn": 1.0})


def test_outline_beside_the_origin_is_a_disc_for_local_planners():
    """As of a fork lift whose frame is at its rear axle: the robot connects, and is kept clear by its circle."""
    ahead = [[0.1, 0.3], [1.0, 0.3], [1.0, -0.3], [0.1, -0.3]]
    body = robot_body("turtlebot2", None, {"global_costmap": {"footprint": ahead}})
    controller = controller_of(body, "dwa", {})
    assert (controller.parameters.footprint, controller.parameters.robot_radius) == ((), 1.045)
    assert body.inner_radius is None


class Slow(Controller):
    """Local planner of another distribution, which takes one limit of the body, and a parameter."""

    name = "slow"
    purpose = "Drives slowly."

    def __init__(self, *, max_vel_x: float = 0.1, part: float = 0.5) -> None:
        self.max_vel_x = max_vel_x
        self.part = part

    def set_plan(self, poses: Poses) -> None:
        """Drive straight on."""

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return a part of the limit."""
        return Velocity(self.part * self.max_vel_x)

    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        """Return whether it stands still."""
        return velocity == Velocity()


def test_a_local_planner_gets_the_limits_of_the_body_that_it_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    load = CONTROLLERS.load
    monkeypatch.setattr(CONTROLLERS, "load", lambda name: Slow if name == "slow" else load(name))
    controller = controller_of(TURTLEBOT, "slow", {"part": 0.25})
    assert isinstance(controller, Slow)
    assert (controller.max_vel_x, controller.part) == (TURTLEBOT.limits.max_vel_x, 0.25)
    with pytest.raises(InvalidParameter, match="has no parameter 'robot_radius'; known: max_vel_x, part"):
        controller_of(TURTLEBOT, "slow", {"robot_radius": 0.2})
