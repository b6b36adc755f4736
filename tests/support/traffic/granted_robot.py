"""Clone of a robot in traffic that is where its commands take it, for tests that play the traffic node."""

import math

from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D, wrap_angle
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.fleet.traffic import MapPoint, TrafficGrants, TrafficReport
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.operators.teleoperation import TeleopCommand, TeleopState
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Payload
from ppaas.nodes.graph import Graph
from ppaas.transforms.planar import transform_message
from tests.support.world.closed_loop import ManualClock
from tests.support.world.planar_world import walled_map

PERIOD, SPACING = 0.05, 0.6


class GrantedRobot:
    """Robot in an empty room of 8 m × 8 m whose base obeys at once.

    Attributes
    ----------
    reports : list of TrafficReport
    results : list of MoveBaseActionResult
    text : str
        Text of the status of the last goal.
    """

    def __init__(self, pose: Pose2D = Pose2D(1.0, 1.0), **parameters: object) -> None:
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.pose, self.command = pose, Twist()
        self.reports: list[TrafficReport] = []
        self.results: list[MoveBaseActionResult] = []
        self.text = ""
        self._number = self._commands = self._state = 0
        build_clone(
            self.graph, build_layers(walled_map(8, 8, [])), model="turtlebot2", initial_pose=tuple(pose),
            parameters={"traffic": {}, **parameters}, robot="tb1",
        )  # fmt: skip
        for topic in ("traffic/report", "move_base/result", "move_base/status", "cmd_vel", "teleop_state"):
            self.graph.tap(topic, self._hear)
        self.run(0.5)

    def _hear(self, _topic: str, message: Payload) -> None:
        match message:
            case TrafficReport():
                self.reports.append(message)
            case MoveBaseActionResult():
                self.results.append(message)
            case Twist():
                self.command = message
            case TeleopState():
                self._state = message.number
            case GoalStatusArray(status_list=[*_, last]):
                self.text = last.text

    @property
    def report(self) -> TrafficReport:
        """The last report."""
        return self.reports[-1]

    def run(self, seconds: float) -> None:
        """Let time pass, in which the robot drives and publishes its odometry."""
        for _ in range(round(seconds / PERIOD)):
            self.clock.advance(PERIOD)
            v, w = self.command.linear.x, self.command.angular.z
            theta = wrap_angle(self.pose.theta + w * PERIOD)
            self.pose = Pose2D(
                self.pose.x + v * PERIOD * math.cos(theta), self.pose.y + v * PERIOD * math.sin(theta), theta
            )
            self._publish()
            self.graph.run_due()

    def _publish(self) -> None:
        stamp = Time.of(self.clock())
        still = transform_message("map", "odom", Pose2D(0.0, 0.0), stamp)
        self.graph.inject("tf", TFMessage([still, transform_message("odom", "base_link", self.pose, stamp)]))
        twist = TwistWithCovariance(Twist(Vector3(self.command.linear.x), Vector3(z=self.command.angular.z)))
        header = Header(stamp=stamp, frame_id="odom")
        self.graph.inject("odom", Odometry(header, "base_link", PoseWithCovariance(Pose.of(self.pose)), twist))

    def grant(self, *cells: tuple[int, int], epoch: int = 1, **fields: object) -> None:
        """Grant cells, whose first is where the robot was at first; repeat it until it is told otherwise."""
        self._number += 1
        way = [MapPoint(1.0 + SPACING * column, 1.0 + SPACING * row) for column, row in cells]
        grants = TrafficGrants(
            Header(frame_id="map"), "tb1", epoch, self._number, self.report.revision, SPACING, way=way, **fields
        )  # type: ignore[arg-type]
        self.graph.inject("traffic/grants", grants)

    def grant_from_here(self, column: int, **fields: object) -> None:
        """Grant the cells from the one where the robot is nearest, along the first row up to a column."""
        here = max(0, min(round((self.pose.x - 1.0) / SPACING), column))
        self.grant(*((each, 0) for each in range(here, column + 1)), **fields)

    def by_hand(self, linear: float = 0.0, angular: float = 0.0, *, request: str = "", enable: bool = True) -> None:
        """Send a command of a driver, who hears each state at once."""
        self._commands += 1
        command = TeleopCommand(
            "desk", self._commands, linear, angular, enable, self._state, 0.0, self._state, request, "ada"
        )
        self.graph.inject("teleop_cmd", command)

    def send_goal(self, column: float, row: float, goal_id: str = "there") -> None:
        """Send a goal in the centre of a cell, or beside it, as an operator does."""
        goal = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(1.0 + SPACING * column, 1.0 + SPACING * row)))
        self.graph.inject("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(goal), GoalID(id=goal_id)))
        self.run(0.3)

    def cancel(self) -> None:
        """Cancel the goal."""
        self.graph.inject("move_base/cancel", GoalID())
        self.run(0.3)

    def is_at(self, column: float, row: float) -> bool:
        """Return whether the robot is within 0.1 m of the centre of a cell, or of a place beside it."""
        return math.hypot(self.pose.x - 1.0 - SPACING * column, self.pose.y - 1.0 - SPACING * row) < 0.1
