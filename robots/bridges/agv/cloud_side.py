"""One AGV in the cloud: the link of its robot, with the topics that are published and received."""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from dataclasses import dataclass

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.messages import Message, decode, encode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.std_msgs import String, Time
from ppaas.messages.geometry_msgs import PoseStamped, PoseWithCovarianceStamped
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray
from ppaas.messages.nav2_motions import FollowPathActionGoal
from ppaas.wire.vda5050.fields import Velocity
from ppaas.wire.vda5050.master.instructions import PathEnded, Progress
from ppaas.wire.vda5050.master.master_control import Path
from ppaas.wire.vda5050.master.route import route_of
from robots.bridges.agv import ros_messages
from robots.bridges.core.cloud_link import CloudLink

logger = logging.getLogger(__name__)

FAREWELL = 1.0
"""Longest time for which a robot that leaves waits until its messages are sent [s]."""

ACTIONS = "agv/instant_actions"
"""Topic of types of instant actions, as ``startPause``, that operators send the AGV."""


@dataclass(frozen=True, slots=True)
class Requests:
    """Called with what comes from the cloud: paths, the ids of cancelled ones, poses, and types of instant actions.

    ``renewed`` is called when a session begins, whose clone may have no path.
    """

    follow: Callable[[Path], None]
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
    requests : Requests
    """

    def __init__(self, url: str, token: str, robot: str, requests: Requests) -> None:
        self.link = CloudLink(url, robot=robot, token=token, renewed=requests.renewed)
        self._requests = requests
        self._sending: set[asyncio.Task[None]] = set()

    async def subscribe(self) -> None:
        """Subscribe to paths and what else concerns the AGV."""
        requests, link = self._requests, self.link
        await link.advertise(ACTIONS, "std_msgs/String")
        await link.subscribe("follow_path/cancel", "actionlib_msgs/GoalID", self._cancel)
        await link.subscribe("follow_path/goal", "nav2_msgs/FollowPathActionGoal", self._follow)
        await link.subscribe("initialpose", "geometry_msgs/PoseWithCovarianceStamped", self._initial_pose)
        await link.subscribe(ACTIONS, "std_msgs/String", lambda text: requests.action(decode(String, text).data))

    def _follow(self, text: bytes) -> None:
        goal = decode(FollowPathActionGoal, text)
        poses = [_pose(stamped) for stamped in goal.goal.path.poses if isinstance(stamped, PoseStamped)]
        self._requests.follow(Path(goal.goal_id.id, route_of(poses)))

    def _cancel(self, text: bytes) -> None:
        self._requests.cancel(decode(GoalID, text).id)

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
            ("odom", ros_messages.odometry(pose, velocity, stamp)),
            ("tf", ros_messages.map_to_odom(stamp)),
            ("amcl_pose", ros_messages.amcl_pose(pose, deviation, stamp)),
        )
        self.link.publish_together("pose", ((topic, encode(message)) for topic, message in messages))

    def progress(self, progress: Progress) -> None:
        """Publish progress along a path."""
        self.link.publish_newest("follow_path/feedback", encode(ros_messages.feedback(progress, _now())))

    def ended(self, end: PathEnded) -> None:
        """Publish the end of a path, which must arrive."""
        task = asyncio.create_task(
            self.link.publish("follow_path/result", encode(ros_messages.result(end, _now()))), name="result"
        )
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
