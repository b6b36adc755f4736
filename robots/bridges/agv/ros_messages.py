"""Messages of ROS for the states of an AGV."""

from collections.abc import Mapping, Sequence

from ppaas.diagnosis.rules.link import AGV
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import (
    Pose,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray, DiagnosticLevel, DiagnosticStatus, KeyValue
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
from ppaas.wire.vda5050.fields import Velocity
from ppaas.wire.vda5050.master.instructions import STOPPING, PathEnded, Progress, in_words, standing
from ppaas.wire.vda5050.states import State

DEVIATION = 0.05
"""Standard deviation of the position of an AGV that reports none [m]."""


def odometry(pose: Pose2D, velocity: Velocity | None, stamp: Time) -> Odometry:
    """Return the odometry of an AGV that localizes itself: its frame is the map's."""
    vx, vy, omega = (0.0, 0.0, 0.0) if velocity is None else (velocity.vx, velocity.vy, velocity.omega)
    twist = Twist(Vector3(x=vx or 0.0, y=vy or 0.0), Vector3(z=omega or 0.0))
    return Odometry(
        Header(stamp=stamp, frame_id=ODOM), BASE_LINK, PoseWithCovariance(Pose.of(pose)), TwistWithCovariance(twist)
    )


def map_to_odom(stamp: Time) -> TFMessage:
    """Return the transform from the map to the odometry, which is the identity."""
    return TFMessage([transform_message(MAP, ODOM, Pose2D(0.0, 0.0), stamp)])


def amcl_pose(pose: Pose2D, deviation: float | None, stamp: Time) -> PoseWithCovarianceStamped:
    """Return the pose with its deviation [m]."""
    variance = (DEVIATION if deviation is None else deviation) ** 2
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = covariance[35] = variance
    header = Header(stamp=stamp, frame_id=MAP)
    return PoseWithCovarianceStamped(header, PoseWithCovariance(Pose.of(pose), covariance))


def feedback(progress: Progress, stamp: Time) -> FollowPathActionFeedback:
    """Return the feedback of FollowPath."""
    status = GoalStatus(GoalID(id=progress.path), int(Status.ACTIVE), progress.text)
    return FollowPathActionFeedback(Header(stamp=stamp), status, FollowPathFeedback(progress.distance, progress.speed))


def result(end: PathEnded, stamp: Time) -> FollowPathActionResult:
    """Return the result of FollowPath."""
    status = Status.SUCCEEDED if end.code is FollowPathError.NONE else Status.ABORTED
    goal = GoalStatus(GoalID(id=end.path), int(status), end.reason)
    return FollowPathActionResult(Header(stamp=stamp), goal, FollowPathResult(int(end.code), end.reason))


def diagnostics(
    name: str, state: State | None, problem: str, stamp: Time, *,
    facts: Mapping[str, str], complaint: str = "", notes: Sequence[str] = (),
) -> DiagnosticArray:  # fmt: skip
    """Return how an AGV is: its errors, its last contradiction, and why it is not connected or localized.

    Parameters
    ----------
    name : str
        Manufacturer and serial number.
    state : State or None
        Newest state.
    problem : str
        Why the AGV cannot be used; empty if it can.
    stamp : Time
    facts : mapping of str to str
        What is known of the AGV besides its state, such as its connection.
    complaint : str
        The last contradiction; empty if there was none.
    notes : sequence of str
        What is wrong with the robot's file.
    """
    told = {**facts, **({} if state is None else _values(state))}
    words = ", ".join(f"{key} {value}" for key, value in told.items() if value)
    level = DiagnosticLevel.ERROR if problem else DiagnosticLevel.OK
    statuses = [_status(level, f"{name}{AGV}", f"{problem or 'in use'} ({words})")]
    statuses[0].values = [KeyValue(key, value) for key, value in told.items()]
    if complaint:
        statuses.append(_status(DiagnosticLevel.WARN, f"{name}: order", complaint))
    statuses += [_status(DiagnosticLevel.WARN, f"{name}: file", note) for note in notes]
    for error in () if state is None else state.errors[:20]:
        level = DiagnosticLevel.ERROR if error.error_level in STOPPING else DiagnosticLevel.WARN
        statuses.append(_status(level, f"{name}: {error.error_type[:60]}", in_words(error)))
    return DiagnosticArray(Header(stamp=stamp), statuses)


def _values(state: State) -> dict[str, str]:
    power, position = state.power_supply, state.mobile_robot_position
    return {
        "operating mode": state.operating_mode,
        "map": "" if position is None else position.map_id[:60],
        "errors": str(len(state.errors)),
        "stands because": standing(state),
        "charge [%]": f"{power.state_of_charge:.0f}",
        "charging": str(power.charging).lower(),
        "order": state.order_id[:100],
    }


def _status(level: DiagnosticLevel, name: str, text: str) -> DiagnosticStatus:
    return DiagnosticStatus(int(level), name, text)
