"""Messages of robots that localize themselves and follow paths: pose, progress along a path, and its end."""

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, PoseWithCovarianceStamped, Twist, TwistWithCovariance
from ppaas.messages.nav2_motions import (
    FollowPathActionFeedback,
    FollowPathActionResult,
    FollowPathError,
    FollowPathFeedback,
    FollowPathResult,
)
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import BASE_LINK, MAP, ODOM
from ppaas.transforms.planar import transform_message


def odometry(pose: Pose2D, twist: Twist, stamp: Time) -> Odometry:
    """Return the odometry of a robot that localizes itself: its frame is the map's."""
    return Odometry(
        Header(stamp=stamp, frame_id=ODOM), BASE_LINK, PoseWithCovariance(Pose.of(pose)), TwistWithCovariance(twist)
    )


def map_to_odom(stamp: Time) -> TFMessage:
    """Return the transform from the map to the odometry, which is the identity."""
    return TFMessage([transform_message(MAP, ODOM, Pose2D(0.0, 0.0), stamp)])


def amcl_pose(pose: Pose2D, deviation: float, stamp: Time) -> PoseWithCovarianceStamped:
    """Return the pose with its standard deviation [m, rad]."""
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = covariance[35] = deviation**2
    header = Header(stamp=stamp, frame_id=MAP)
    return PoseWithCovarianceStamped(header, PoseWithCovariance(Pose.of(pose), covariance))


def feedback(path: str, text: str, distance: float, speed: float, stamp: Time) -> FollowPathActionFeedback:
    """Return the feedback of FollowPath: the rest of the path [m], the speed [m/s], and a text."""
    status = GoalStatus(GoalID(id=path), int(Status.ACTIVE), text)
    return FollowPathActionFeedback(Header(stamp=stamp), status, FollowPathFeedback(distance, speed))


def result(path: str, code: FollowPathError, reason: str, stamp: Time) -> FollowPathActionResult:
    """Return the result of FollowPath."""
    status = Status.SUCCEEDED if code is FollowPathError.NONE else Status.ABORTED
    goal = GoalStatus(GoalID(id=path), int(status), reason)
    return FollowPathActionResult(Header(stamp=stamp), goal, FollowPathResult(int(code), reason))
