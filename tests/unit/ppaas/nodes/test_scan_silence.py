"""Scans that do not come, or that nothing can be done with: the reason, for as long as the pose is not renewed."""

import pytest

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import TransformError
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import String, Time
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.base import Context, Node
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.graph import Graph
from ppaas.nodes.grid_slam.node import GridSlamNode
from ppaas.nodes.grid_slam.parameters import GridSlamParameters
from ppaas.nodes.scan_silence import ScanSilence
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.robot_model.known_models import robot_model
from ppaas.transforms.planar import transform_message
from tests.support.world.planar_world import World, walled_map

GRID = walled_map(6, 5, [(3, 0, 3.2, 2)])
START = Pose2D(1.0, 1.0, 0.5)


def amcl(context: Context) -> Node:
    return AmclNode(context, build_layers(GRID), START, AmclParameters())


def grid_slam(context: Context) -> Node:
    return GridSlamNode(context, GridSlamParameters())


class Robot:
    """Robot with its localization, whose sensors may fail."""

    def __init__(self, make: object) -> None:
        self.clock = ManualClock(100.0)
        self.world = World(GRID, START)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        model, state = robot_model("turtlebot2"), StatePublisherParameters()
        self.graph.add(lambda context: StatePublisherNode(context, model, state))
        self.status = "amcl/status" if make is amcl else "grid_slam/status"
        self.graph.add(make)  # type: ignore[arg-type]
        self.odometry = self.scans = True

    def drive(self, seconds: float, *, odom_clock: float = 0.0, broken: bool = False) -> str:
        """Let time pass; return the status of localization."""
        for _ in range(round(seconds * 10)):
            self.clock.advance(0.1)
            if self.odometry:
                message = self.world.odometry(self.clock() + odom_clock)
                if broken:
                    message.pose.pose.position.x = float("nan")
                self.inject("odom", message)
            if self.scans:
                self.inject("scan", self.world.scan(self.clock()))
            self.graph.run_due()
        latched = self.graph.latched(self.status)
        return latched.data if isinstance(latched, String) else ""

    def inject(self, topic: str, message: Message) -> None:
        try:
            self.graph.inject(topic, message)
        except Exception as error:  # noqa: BLE001 - a client gets it as a status
            assert isinstance(message, Odometry | LaserScan), error


@pytest.fixture(params=[amcl, grid_slam], ids=["amcl", "grid_slam"])
def robot(request: pytest.FixtureRequest) -> Robot:
    robot = Robot(request.param)
    assert robot.drive(3.0) == ""
    return robot


def test_scans_that_stop_are_reported_until_they_come_again(robot: Robot) -> None:
    robot.scans = False
    assert robot.drive(1.5) == ""
    assert robot.drive(2.0) == "no scan comes any more, or none that can be read"
    robot.scans = True
    assert robot.drive(0.5) == ""


def test_odometry_that_stops_is_reported_although_scans_come(robot: Robot) -> None:
    robot.odometry = False
    assert robot.drive(5.0) == "scans wait for odometry, which does not come any more or is refused"
    robot.odometry = True
    assert robot.drive(0.5) == ""


def test_odometry_that_is_refused_is_reported_although_scans_come(robot: Robot) -> None:
    assert robot.drive(5.0, broken=True) == "scans wait for odometry, which does not come any more or is refused"
    assert robot.drive(0.5) == ""


@pytest.mark.parametrize("jump", [-3600.0, -30.0, -1.5, 1.5, 30.0, 3600.0])
def test_odometry_whose_clock_jumped_is_reported(robot: Robot, jump: float) -> None:
    assert robot.drive(5.0, odom_clock=jump) != ""


def test_a_robot_that_never_sent_a_scan_may_localize_itself() -> None:
    robot = Robot(amcl)
    robot.scans = False
    assert robot.drive(10.0) == ""


def test_a_transform_that_is_refused_is_named_with_the_odometry_that_is_missing() -> None:
    frames = FrameListener()
    silence = ScanSilence(frames)
    frames.hear("tf", TFMessage([transform_message("odom", "base_link", START, Time.of(1.0))]), 1.0)
    silence.scan_came(1.0)
    silence.scan_used(1.0)
    assert silence.reason(2.0) == ""
    silence.transform_refused(TransformError("transform 'odom' → 'base_link' is not finite"))
    silence.scan_came(9.0)
    assert silence.reason(9.0) == (
        "scans wait for odometry, which does not come any more or is refused; a transform is refused: transform "
        "'odom' → 'base_link' is not finite"
    )
