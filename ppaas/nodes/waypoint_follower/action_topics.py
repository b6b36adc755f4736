"""Publishers of the action ``follow_waypoints``: status, feedback and results of lists."""

from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav2_msgs import (
    FollowWaypointsActionFeedback,
    FollowWaypointsActionResult,
    FollowWaypointsError,
    FollowWaypointsFeedback,
    FollowWaypointsResult,
    Progress,
    WaypointStatus,
)
from ppaas.navigation.action_goals import GoalList, GoalState
from ppaas.navigation.waypoints import Waypoints
from ppaas.nodes import topics
from ppaas.nodes.action_publisher import status_array, status_of
from ppaas.nodes.base import Context
from ppaas.nodes.frames import MAP


class WaypointTopics:
    """Publishes status, feedback and results of lists of waypoints.

    Parameters
    ----------
    context : Context
        The node's context.
    """

    def __init__(self, context: Context) -> None:
        self._context = context

    def _header(self) -> Header:
        return Header(stamp=Time.of(self._context.now()))

    def status(self, lists: GoalList[Waypoints]) -> None:
        """Publish the status of all lists."""
        self._context.publish(topics.WAYPOINTS_STATUS.name, status_array(lists, self._context))

    def feedback(self, state: GoalState[Waypoints]) -> None:
        """Publish the waypoint that the robot drives to."""
        status = status_of(state.goal, Status.ACTIVE, state.text)
        feedback = FollowWaypointsActionFeedback(self._header(), status, FollowWaypointsFeedback(state.goal.index))
        self._context.publish(topics.WAYPOINTS_FEEDBACK.name, feedback)

    def result(self, ended: GoalState[Waypoints], error: FollowWaypointsError) -> None:
        """Publish the result of a list."""
        waypoints = ended.goal
        missed = [
            WaypointStatus(
                Progress.FAILED,
                missed.index,
                PoseStamped(Header(frame_id=MAP), Pose.of(waypoints.poses[missed.index])),
                FollowWaypointsError.UNKNOWN,
                missed.reason,
            )
            for missed in sorted(waypoints.missed, key=lambda each: each.index)
        ]
        result = FollowWaypointsResult(missed, int(error), ended.text if error else "")
        status = status_of(waypoints, ended.status, ended.text)
        self._context.publish(topics.WAYPOINTS_RESULT.name, FollowWaypointsActionResult(self._header(), status, result))
