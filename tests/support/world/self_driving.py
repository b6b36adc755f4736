"""Clone of a robot that localizes itself and follows paths itself, for tests."""

import math

import msgspec

from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.messages import encode
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.move_base_msgs import MoveBaseActionResult
from ppaas.messages.nav2_motions import (
    FollowPathActionFeedback,
    FollowPathActionGoal,
    FollowPathActionResult,
    FollowPathError,
    FollowPathFeedback,
    FollowPathResult,
)
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.base import Payload
from ppaas.nodes.graph import Graph
from ppaas.transforms.planar import transform_message
from tests.support.world.closed_loop import ManualClock
from tests.support.world.planar_world import walled_map

PERIOD = 0.1


class SelfDriving:
    """Robot in a room of 8 m × 8 m that is where its test puts it.

    Attributes
    ----------
    paths : list of FollowPathActionGoal
        Paths that Move Base has sent.
    cancelled : list of str
        Ids of cancelled paths.
    results : list of MoveBaseActionResult
    """

    def __init__(self, **parameters: object) -> None:
        self.clock = ManualClock(1000.0)
        self.graph = Graph(clock=self.clock, stamp_clock=self.clock)
        self.pose = Pose2D(1.0, 1.0, 0.0)
        self.paths: list[FollowPathActionGoal] = []
        self.cancelled: list[str] = []
        self.results: list[MoveBaseActionResult] = []
        self.text = ""
        build_clone(
            self.graph, build_layers(walled_map(8, 8, [])), model="turtlebot2", initial_pose=(1.0, 1.0, 0.0),
            parameters={"follow_path": {}} | parameters,
        )  # fmt: skip
        for topic in ("follow_path/goal", "follow_path/cancel", "move_base/result", "move_base/status"):
            self.graph.tap(topic, self._hear)
        self.run(0.5)

    def _hear(self, topic: str, message: Payload) -> None:
        match message:
            case FollowPathActionGoal():
                self.paths.append(message)
            case GoalID():
                self.cancelled.append(message.id)
            case MoveBaseActionResult():
                self.results.append(message)
            case GoalStatusArray(status_list=[*_, last]):
                self.text = last.text

    def run(self, seconds: float, *, localized: bool = True) -> None:
        """Let time pass, in which the robot publishes its pose."""
        for _ in range(round(seconds / PERIOD)):
            self.clock.advance(PERIOD)
            if localized:
                still = transform_message("map", "odom", Pose2D(0.0, 0.0), Time.of(self.clock()))
                self.graph.inject("tf", TFMessage([still]))
                self.inject_odometry()
            self.graph.run_due()

    def inject_odometry(self) -> None:
        """Publish the pose in the frame of the odometry, which is that of the map."""
        moved = transform_message("odom", "base_link", self.pose, Time.of(self.clock()))
        self.graph.inject("tf", TFMessage([moved]))

    def send_goal(self, x: float, y: float, yaw: float = 0.0) -> None:
        """Send a goal, as an operator does."""
        goal = PoseStamped(Header(frame_id="map"), Pose.of(Pose2D(x, y, yaw)))
        self.graph.inject("move_base_simple/goal", goal)
        self.run(0.5)

    def end_of_path(self) -> Pose2D:
        """Return the last pose of the last path."""
        poses = msgspec.json.decode(encode(self.paths[-1].goal.path), type=dict)["poses"]
        end = poses[-1]["pose"]
        turn = 2.0 * math.atan2(end["orientation"]["z"], end["orientation"]["w"])
        return Pose2D(end["position"]["x"], end["position"]["y"], turn)

    def feed_back(self, path: str | None = None) -> None:
        """Publish feedback of the last path, or of another."""
        status = GoalStatus(GoalID(id=path or self.paths[-1].goal_id.id), int(Status.ACTIVE))
        message = FollowPathActionFeedback(Header(), status, FollowPathFeedback(1.0, 0.5))
        self.graph.inject("follow_path/feedback", message)

    def end(self, status: Status, reason: str = "", path: str | None = None) -> None:
        """Publish the result of the last path, or of another."""
        ended = GoalStatus(GoalID(id=path or self.paths[-1].goal_id.id), int(status))
        code = FollowPathError.NONE if status is Status.SUCCEEDED else FollowPathError.UNKNOWN
        message = FollowPathActionResult(Header(), ended, FollowPathResult(int(code), reason))
        self.graph.inject("follow_path/result", message)
        self.run(0.5)
