"""Node ``move_base`` of a robot that follows paths itself."""

from typing import Any, ClassVar

from ppaas.messages.nav2_motions import FollowPathActionFeedback, FollowPathActionResult
from ppaas.navigation import events
from ppaas.navigation.move_base import State
from ppaas.nodes import topics
from ppaas.nodes.base import Context, Demands, Payload, Topic
from ppaas.nodes.follow_path.path_follower import PathFollower
from ppaas.nodes.move_base.node import MoveBaseNode

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
    controller : PathFollower
    options
        As of `MoveBaseNode`.
    """

    demands: ClassVar[Demands | None] = None
    subscribes: ClassVar[tuple[Topic, ...]] = (
        *MoveBaseNode.subscribes, topics.FOLLOW_PATH_FEEDBACK, topics.FOLLOW_PATH_RESULT,
    )  # fmt: skip
    publishes: ClassVar[tuple[Topic, ...]] = (
        *MoveBaseNode.publishes, topics.FOLLOW_PATH_GOAL, topics.FOLLOW_PATH_CANCEL,
    )  # fmt: skip

    def __init__(self, context: Context, *, controller: PathFollower, **options: Any) -> None:
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

    def _feed(self, event: events.Event) -> None:
        super()._feed(event)
        if self._machine.state is not State.PLANNING:
            self._ticks_without_plan = 0
        elif isinstance(event, events.ControlTick):
            self._ticks_without_plan += 1
        driving = self._machine.goals.active is not None
        if self._follower.active and (not driving or self._ticks_without_plan > 1):
            self._follower.cancel()
