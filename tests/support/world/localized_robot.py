"""A simulated robot with localization alone, on a manual clock, that is stepped only as often as scans are needed."""

import math
from collections.abc import Callable
from typing import NamedTuple

from ppaas.clock import ManualClock
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.localization.parameters import AmclParameters
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.nodes.amcl.node import AmclNode
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.robot_model.known_models import robot_model
from tests.support.world.closed_loop import RobotWorld
from tests.support.world.planar_world import error_of

Command = Callable[[Pose2D], tuple[float, float]]
"""Returns linear and angular velocity [m/s, rad/s] from the true pose."""


class Errors(NamedTuple):
    """Largest errors of the told pose, in position [m] and heading [rad]."""

    position: float
    heading: float


def stand(_: Pose2D) -> tuple[float, float]:
    """Command no motion."""
    return 0.0, 0.0


class LocalizedRobot:
    """The robot of a world and the nodes that localize it.

    Parameters
    ----------
    world : RobotWorld
        World of the robot.
    initial : Pose2D, optional
        Initial pose that localization gets; the true one by default.
    **parameters
        Parameters of amcl.
    """

    def __init__(self, world: RobotWorld, initial: Pose2D | None = None, **parameters: float | bool) -> None:
        self.world = world
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.told: list[PoseWithCovarianceStamped] = []
        self.clouds = 0
        self.change: Callable[[LaserScan], LaserScan] = lambda scan: scan
        layers = build_layers(world.grid)
        model, state = robot_model("turtlebot2"), StatePublisherParameters()
        self.graph.add(lambda context: StatePublisherNode(context, model, state))
        read = AmclParameters(**parameters)
        self.node = self.graph.add(lambda context: AmclNode(context, layers, initial or world.pose, read))
        self.graph.tap("amcl_pose", lambda _, message: self.told.append(message))
        self.graph.tap("particlecloud", lambda *_: self._count_cloud())

    def _count_cloud(self) -> None:
        self.clouds += 1

    def step(self, command: Command = stand, seconds: float = 1.0) -> Errors:
        """Drive for a time [s], send odometry and a scan; return the errors of the told pose."""
        linear, angular = command(self.world.pose)
        self.world.move(linear, angular, seconds)
        self.clock.advance(seconds)
        self.graph.inject("odom", self.world.odometry(self.clock()))
        self.graph.inject("scan", self.change(self.world.scan(self.clock())))
        return Errors(*error_of(self.pose, self.world.pose))

    def run(self, minutes: float, command: Command = stand, seconds: float = 1.0) -> Errors:
        """Step for a time [min]; return the largest errors."""
        errors = [self.step(command, seconds) for _ in range(round(60.0 * minutes / seconds))]
        return Errors(max(error.position for error in errors), max(error.heading for error in errors))

    @property
    def pose(self) -> Pose2D:
        """The pose that was told last."""
        return self.told[-1].pose.pose.planar()

    @property
    def heading_deviation(self) -> float:
        """Standard deviation of the heading that was told last [rad]."""
        return math.sqrt(self.told[-1].pose.covariance[35])
