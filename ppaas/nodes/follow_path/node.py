"""Node ``move_base`` of a robot that follows paths itself, and its local planner, by Nav2's action FollowPath."""

import math
from itertools import count
from typing import Any, ClassVar

from ppaas.controllers.base import Controller, ControlRequest, PathGivenUp, Velocity
from ppaas.geometry import Pose2D, Poses, yaw_of
from ppaas.messages.actionlib_msgs import GoalID, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.nav2_motions import (
    FollowPathActionFeedback,
    FollowPathActionGoal,
    FollowPathActionResult,
    FollowPathGoal,
)
from ppaas.navigation import events
from ppaas.navigation.move_base import GoalPhase
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Payload, Topic
from ppaas.nodes.frames import MAP
from ppaas.nodes.move_base.node import MoveBaseNode
from ppaas.parameters import Parameters, check_numbers
from ppaas.planners.path_json import path_message

# -- path follower -----------------------------------------------------------------------------------------------------


class FollowPathParameters(Parameters, frozen=True):
    """Parameters of `RobotPathFollower`.

    Parameters
    ----------
    patience : float
        Time without feedback of the robot after which the goal fails [s].
    xy_goal_tolerance : float
        Largest distance from the end of the path at which the robot may end it [m].
    yaw_goal_tolerance : float
        Largest difference to the direction at the end [rad]; it is not checked by default.
    """

    patience: float = 20.0
    xy_goal_tolerance: float = 0.5
    yaw_goal_tolerance: float = math.pi

    def __post_init__(self) -> None:
        """Check the ranges."""
        check_numbers(self, positive=("patience", "xy_goal_tolerance", "yaw_goal_tolerance"))


class RobotPathFollower(Controller):
    """Publishes each plan as ``follow_path/goal``, and takes the robot's feedback and result.

    A result is not believed where localization says that the robot is not at the end of the path.

    Parameters
    ----------
    context : Context
        Context of the node that publishes the topics.
    parameters : FollowPathParameters
    """

    name = "follow_path"
    purpose = "the robot follows paths itself"
    predicts = True

    def __init__(self, context: Context, parameters: FollowPathParameters) -> None:
        self.parameters = parameters
        self._context = context
        self._numbers = count(1)
        self._id = ""
        self._end = Pose2D(0.0, 0.0)
        self._heard_at = -math.inf
        self._result: FollowPathActionResult | None = None

    @property
    def active(self) -> bool:
        """True from the plan until `cancel`, also after the robot has ended its path."""
        return bool(self._id)

    def set_plan(self, poses: Poses) -> None:
        """Send a plan to the robot, in place of the one before."""
        now = self._context.now()
        x, y, _, qx, qy, qz, qw = poses[-1].tolist()
        self._end, self._result = Pose2D(x, y, yaw_of(qx, qy, qz, qw)), None
        self._id = f"{self.name}-{next(self._numbers)}-{now:.3f}"
        self._heard_at = self._context.elapsed()
        header = Header(stamp=Time.of(now), frame_id=MAP)
        goal = FollowPathActionGoal(
            header=header, goal_id=GoalID(header.stamp, self._id), goal=FollowPathGoal(path_message(poses, header))
        )
        self._context.publish(topics.FOLLOW_PATH_GOAL.name, goal)

    def cancel(self) -> None:
        """Stop the robot, if it follows a path."""
        if self._id and self._result is None:
            self._context.publish(topics.FOLLOW_PATH_CANCEL.name, GoalID(id=self._id))
        self._id = ""
        self._context.forget(topics.FOLLOW_PATH_GOAL.name)

    def hear(self, path: str) -> None:
        """Note feedback of the robot; feedback for another path does not count."""
        if path == self._id:
            self._heard_at = self._context.elapsed()

    def take(self, result: FollowPathActionResult) -> None:
        """Take a result of the robot; the result of another path does not count."""
        if result.status.goal_id.id == self._id and result.status.status in tuple(Status):
            self._result = result

    def is_goal_reached(self, pose: Pose2D, velocity: Velocity) -> bool:
        """Return whether the robot has ended its path, at the end of it.

        Raises
        ------
        PathGivenUp
            The robot is elsewhere.
        """
        if self._result is None or self._result.status.status != Status.SUCCEEDED:
            return False
        apart, turned = pose.distance_to(self._end), abs(math.remainder(pose.theta - self._end.theta, math.tau))
        given = self.parameters
        if apart > given.xy_goal_tolerance:
            limit = f"xy_goal_tolerance is {given.xy_goal_tolerance:g} m"
            raise PathGivenUp(f"the robot says that it is at its goal, but is {apart:.2f} m away ({limit})")
        if turned > given.yaw_goal_tolerance:
            limit = f"yaw_goal_tolerance is {given.yaw_goal_tolerance:g} rad"
            raise PathGivenUp(f"the robot is at its goal, but turned by {turned:.2f} rad ({limit})")
        return True

    def compute_velocity(self, request: ControlRequest) -> Velocity:
        """Return no velocity, since the robot drives itself.

        Raises
        ------
        PathGivenUp
            The robot gave up, or says nothing.
        """
        if self._result is not None and self._result.status.status != Status.SUCCEEDED:
            reason = self._result.result.error_msg or self._result.status.text or "the robot gave no reason"
            raise PathGivenUp(f"the robot does not follow the path: {reason}")
        silence = self._context.elapsed() - self._heard_at
        if silence > self.parameters.patience:
            raise PathGivenUp(f"the robot has not answered for {silence:.1f} s: publish 'follow_path/feedback'")
        return Velocity()


# -- the node ----------------------------------------------------------------------------------------------------------

DEFAULTS = {
    "planner_frequency": 0.0,
    "controller_frequency": 5.0,
    "recovery_behavior_enabled": False,
    "transform_tolerance": 5.0,
}
"""Parameters of Move Base that differ for such a robot: it plans once, and the pose may come once a second."""


class PathFollowingNode(MoveBaseNode):
    """Move Base that plans, and leaves driving to the robot, by the topics of Nav2's action FollowPath.

    Goals, waypoints, status, feedback and results are the same as for any robot. ``cmd_vel`` is always zero.
    A robot that follows a path while Move Base plans another is stopped if there is none within a control cycle.

    Parameters
    ----------
    context : Context
        The node's context.
    controller : RobotPathFollower
    options
        As of `MoveBaseNode`.
    """

    not_by_hand: ClassVar[str] = "it follows paths itself, and obeys no velocities"
    demands: ClassVar[Demands | None] = None
    subscribes: ClassVar[tuple[Topic, ...]] = (
        *MoveBaseNode.subscribes, topics.FOLLOW_PATH_FEEDBACK, topics.FOLLOW_PATH_RESULT,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        *MoveBaseNode.publishes, topics.FOLLOW_PATH_GOAL, topics.FOLLOW_PATH_CANCEL,
    )  # fmt: skip

    def __init__(self, context: Context, *, controller: RobotPathFollower, **options: Any) -> None:
        super().__init__(context, controller=controller, **options)
        self._surroundings.expect_no_scans()
        self._follower = controller
        self._ticks_without_plan = 0

    def on_message(self, topic: str, message: Payload) -> None:
        """Handle a message; raises as Move Base's method does."""
        match message:
            case FollowPathActionFeedback():
                self._follower.hear(message.status.goal_id.id)
            case FollowPathActionResult():
                self._follower.take(message)
            case _:
                super().on_message(topic, message)

    def _hold(self, reason: str) -> None:
        """Stop the robot at once while it is stopped; it gets another path after the release."""
        if reason:
            self._follower.cancel()
        super()._hold(reason)

    def _feed(self, event: events.Event) -> None:
        super()._feed(event)
        if self._machine.state is not GoalPhase.PLANNING:
            self._ticks_without_plan = 0
        elif isinstance(event, events.ControlTick):
            self._ticks_without_plan += 1
        driving = self._machine.goals.active is not None
        if self._follower.active and (not driving or self._ticks_without_plan > 1):
            self._follower.cancel()
