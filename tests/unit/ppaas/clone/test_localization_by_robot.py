"""Clone of a robot that localizes itself and sends scans: its pose is believed, and the scans mark obstacles."""

import numpy as np
import pytest

from ppaas.clock import ManualClock
from ppaas.clone.assembly import build_clone
from ppaas.clone.localization import localizes_itself
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import PPaaSError, Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalStatusArray
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, Twist
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.graph import Graph
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.transforms.planar import transform_message
from tests.support.world.planar_world import World, walled_map

BOX = (2.6, 1.3, 2.9, 1.6)
"""Obstacle that is not on the map [m]."""


class OwnPlace:
    """Robot whose clone need not localize it, and takes it to be elsewhere at first."""

    def __init__(self) -> None:
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        build_clone(
            self.graph, build_layers(walled_map(5, 3, [])), model="turtlebot2", initial_pose=(4.0, 2.0, 1.0),
            parameters={"amcl": {"localize": False}},
        )  # fmt: skip
        self.world = World(walled_map(5, 3, [BOX]), Pose2D(1.0, 1.4, 0.0), drift=0.0)
        self.said: list[str] = []
        self.fastest, self.text = 0.0, ""
        for topic in ("amcl_pose", "particlecloud", "amcl/status"):
            self.graph.tap(topic, lambda topic, _: self.said.append(topic))
        self.graph.tap("cmd_vel", self._on_velocity)
        self.graph.tap("move_base/status", self._on_status)

    def run(self, seconds: float, *, problem: str = "") -> None:
        """Let a time pass, in which the robot publishes its place, unless it has a problem."""
        if problem:
            self.graph.inject("amcl/status", String(problem))
        for _ in range(round(10 * seconds)):
            self.clock.advance(0.1)
            now = self.clock()
            self.graph.inject("odom", self.world.odometry(now))
            if not problem:
                correction = self.world.pose @ self.world.odom.inverse()
                self.graph.inject("tf", TFMessage([transform_message("map", "odom", correction, Time.of(now))]))
            self.graph.inject("scan", self.world.scan(now))
            self.graph.run_due()

    def go(self, x: float, y: float) -> None:
        """Send a goal, as an operator does."""
        goal = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(x, y)))
        self.graph.inject("move_base_simple/goal", goal)

    def _on_velocity(self, _topic: str, message: Twist) -> None:
        self.fastest = max(self.fastest, message.linear.x)

    def _on_status(self, _topic: str, message: GoalStatusArray) -> None:
        self.text = message.status_list[-1].text if message.status_list else ""


def test_amcl_leaves_the_place_to_the_robot_and_scans_mark_obstacles() -> None:
    robot = OwnPlace()
    robot.run(1.0)
    robot.go(4.0, 1.4)
    robot.run(2.0)
    assert robot.fastest > 0.05, robot.text
    assert not robot.said
    node = robot.graph.nodes["move_base"]
    assert isinstance(node, MoveBaseNode) and node.costs is not None
    seen = node.costs.info.to_world(np.argwhere(node.costs.data >= 253))
    assert np.any(np.hypot(seen[:, 0] - 2.6, seen[:, 1] - 1.45) < 0.1), "the box is where the robot sees it"


def test_the_robot_says_why_it_does_not_know_its_place() -> None:
    robot = OwnPlace()
    robot.run(1.0)
    robot.go(4.0, 1.4)
    robot.run(0.5)
    robot.run(1.0, problem="the GPS has no fix")
    assert robot.text == "waiting: not localized: the GPS has no fix"


def test_nothing_searches_for_a_robot_that_localizes_itself() -> None:
    robot, errors = OwnPlace(), list[PPaaSError]()
    robot.graph.call("global_localization", Empty(), errors.append)
    assert isinstance(errors[0], Unavailable) and "localizes itself" in str(errors[0])


@pytest.mark.parametrize(
    ("parameters", "own"),
    [({}, False), ({"amcl": {}}, False), ({"amcl": {"localize": True}}, False), ({"amcl": {"localize": False}}, True),
     ({"amcl": 5}, False)],
)  # fmt: skip
def test_a_robots_parameters_say_whether_it_localizes_itself(parameters: dict[str, object], own: bool) -> None:
    assert localizes_itself(parameters) is own
