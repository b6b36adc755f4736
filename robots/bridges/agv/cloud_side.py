"""One AGV in the cloud: the link of its robot, with the topics that are published and received, as messages of ROS."""

import asyncio
import contextlib
import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from ppaas.clock import epoch
from ppaas.diagnosis.rules.link import AGV
from ppaas.geometry import Pose2D
from ppaas.messages import Message, decode, encode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import PoseStamped, PoseWithCovarianceStamped, Twist, Vector3
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray, DiagnosticLevel, DiagnosticStatus, KeyValue
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav2_motions import FollowPathActionGoal
from ppaas.wire.vda5050.fields import Velocity
from ppaas.wire.vda5050.master.instructions import STOPPING, PathEnded, Progress, in_words, standing
from ppaas.wire.vda5050.master.master_control import AgvPath
from ppaas.wire.vda5050.master.route import route_of
from ppaas.wire.vda5050.states import State
from robots.bridges.core import own_pose
from robots.bridges.core.cloud_link import CloudLink

logger = logging.getLogger(__name__)

FAREWELL = 1.0
"""Longest time for which a robot that leaves waits until its messages are sent [s]."""

ACTIONS = "agv/instant_actions"
"""Topic of types of instant actions, as ``startPause``, that operators send the AGV."""


@dataclass(frozen=True, slots=True)
class CloudCallbacks:
    """Called with what comes from the cloud: paths, the ids of cancelled ones, poses, and types of instant actions.

    ``renewed`` is called when a session begins, whose clone may have no path.
    """

    follow: Callable[[AgvPath], None]
    cancel: Callable[[str], None]
    initial_pose: Callable[[Pose2D], None]
    action: Callable[[str], None]
    renewed: Callable[[], None]


class CloudSide:
    """Link of the robot that an AGV is.

    Parameters
    ----------
    url, token, robot : str
        URL of the cloud, token of the account, id of the robot.
    requests : CloudCallbacks
    """

    def __init__(self, url: str, token: str, robot: str, requests: CloudCallbacks) -> None:
        self.link = CloudLink(url, robot=robot, token=token, renewed=requests.renewed)
        self._requests = requests
        self._paused = False
        self._sending: set[asyncio.Task[None]] = set()

    async def subscribe(self) -> None:
        """Subscribe to paths and what else concerns the AGV."""
        requests, link = self._requests, self.link
        await link.advertise(ACTIONS, "std_msgs/String")
        await link.subscribe("follow_path/cancel", "actionlib_msgs/GoalID", self._cancel)
        await link.subscribe("follow_path/goal", "nav2_msgs/FollowPathActionGoal", self._follow)
        await link.subscribe("initialpose", "geometry_msgs/PoseWithCovarianceStamped", self._initial_pose)
        await link.subscribe(ACTIONS, "std_msgs/String", lambda text: requests.action(decode(String, text).data))
        await link.subscribe("stop/state", "ppaas_msgs/StopState", self._stop)

    def _follow(self, text: bytes) -> None:
        goal = decode(FollowPathActionGoal, text)
        poses = [_pose(stamped) for stamped in goal.goal.path.poses if isinstance(stamped, PoseStamped)]
        self._requests.follow(AgvPath(goal.goal_id.id, route_of(poses)))

    def _cancel(self, text: bytes) -> None:
        self._requests.cancel(decode(GoalID, text).id)

    def _stop(self, text: bytes) -> None:
        """Pause the AGV while its robot is stopped, and end that pause; a pause by others stays."""
        stopped = decode(StopState, text).stopped
        if stopped != self._paused:
            self._paused = stopped
            self._requests.action("startPause" if stopped else "stopPause")

    def _initial_pose(self, text: bytes) -> None:
        self._requests.initial_pose(decode(PoseWithCovarianceStamped, text).pose.pose.planar())

    async def say_farewell(self) -> None:
        """Wait until the ends of paths are sent, for a moment, before the robot leaves."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(FAREWELL):
                await asyncio.gather(*self._sending, return_exceptions=True)
                await self.link.drained()

    # -- publishing ----------------------------------------------------------------------------------------------------

    def pose(self, pose: Pose2D, velocity: Velocity | None, deviation: float | None) -> None:
        """Publish where the AGV is, in one frame."""
        stamp = _now()
        messages: tuple[tuple[str, Message], ...] = (
            ("odom", own_pose.odometry(pose, twist_of(velocity), stamp)),
            ("tf", own_pose.map_to_odom(stamp)),
            ("amcl_pose", own_pose.amcl_pose(pose, DEVIATION if deviation is None else deviation, stamp)),
        )
        self.link.publish_together("pose", ((topic, encode(message)) for topic, message in messages))

    def progress(self, progress: Progress) -> None:
        """Publish progress along a path."""
        message = own_pose.feedback(progress.path, progress.text, progress.distance, progress.speed, _now())
        self.link.publish_newest("follow_path/feedback", encode(message))

    def ended(self, end: PathEnded) -> None:
        """Publish the end of a path, which must arrive."""
        message = own_pose.result(end.path, end.code, end.reason, _now())
        task = asyncio.create_task(self.link.publish("follow_path/result", encode(message)), name="result")
        self._sending.add(task)
        task.add_done_callback(self._sent)

    def localization(self, problem: str) -> None:
        """Publish why the AGV is not localized; empty if it is."""
        self.link.publish_newest("amcl/status", encode(String(problem)))

    def diagnostics(self, message: DiagnosticArray) -> None:
        """Publish how the AGV is."""
        self.link.publish_newest("diagnostics", encode(message))

    def _sent(self, task: asyncio.Task[None]) -> None:
        self._sending.discard(task)
        if not task.cancelled() and task.exception() is not None:
            logger.warning("the end of a path was not sent: %s", task.exception())


def _pose(stamped: PoseStamped) -> Pose2D:
    return stamped.pose.planar()


def _now() -> Time:
    return Time.of(epoch())


# -- messages of ROS for the states of an AGV --------------------------------------------------------------------------

DEVIATION = 0.05
"""Standard deviation of the position of an AGV that reports none [m]."""


def twist_of(velocity: Velocity | None) -> Twist:
    """Return the velocity of an AGV; zero if it reports none."""
    vx, vy, omega = (0.0, 0.0, 0.0) if velocity is None else (velocity.vx, velocity.vy, velocity.omega)
    return Twist(Vector3(x=vx or 0.0, y=vy or 0.0), Vector3(z=omega or 0.0))


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
