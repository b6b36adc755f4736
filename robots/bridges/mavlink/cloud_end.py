"""Link of the robot that a vehicle is: what is subscribed to and published, as messages of ROS."""

import asyncio
import contextlib
import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import msgspec

from ppaas.clock import epoch
from ppaas.geometry import Pose2D
from ppaas.messages import Message, decode, encode
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import PoseStamped, PoseWithCovarianceStamped, Twist, Vector3
from ppaas.messages.health.diagnostic_msgs import DiagnosticArray, DiagnosticStatus
from ppaas.messages.health.stops import StopState
from ppaas.messages.nav2_motions import FollowPathActionGoal
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.polygons import Points
from ppaas.wire.vda5050.master.instructions import PathEnded
from ppaas.wire.vda5050.master.route import route_of
from robots.bridges.core import own_pose
from robots.bridges.core.cloud_link import CloudLink
from robots.bridges.mavlink.mission import PathProgress
from robots.bridges.mavlink.place import VehicleMotion
from robots.bridges.mavlink.vehicle import BatteryReading

logger = logging.getLogger("ppaas.bridge")

GOALS_PERIOD = 0.2
"""Least time between two messages on the goals of the robot [s]."""

FAREWELL = 1.0
"""Longest time for which a robot that leaves waits until its messages are sent [s]."""


@dataclass(frozen=True, slots=True)
class Requests:
    """Called with what comes from the cloud.

    Attributes
    ----------
    velocity : callable
        Takes the speed forward [m/s] and the turn counter-clockwise [rad/s].
    goals : callable
        Takes the ids of the active goals.
    follow : callable
        Takes the id of a path and its corners on the map [m].
    cancel : callable
        Takes the id of a cancelled path.
    initial_pose : callable
        Takes a pose on the map.
    stop : callable
        Takes whether the robot is stopped.
    """

    velocity: Callable[[float, float], None]
    goals: Callable[[frozenset[str]], None]
    follow: Callable[[str, Points], None]
    cancel: Callable[[str], None]
    initial_pose: Callable[[Pose2D], None]
    stop: Callable[[bool], None]


class CloudEnd:
    """Link of the robot.

    Parameters
    ----------
    url, token, robot : str
        URL of the cloud, token of the account, id of the robot.
    requests : Requests
    """

    def __init__(self, url: str, token: str, robot: str, requests: Requests) -> None:
        self.link = CloudLink(url, robot=robot, token=token)
        self._requests = requests
        self._sending: set[asyncio.Task[None]] = set()

    async def subscribe(self, *, follows_paths: bool) -> None:
        """Subscribe to what concerns the vehicle."""
        link = self.link
        await link.advertise("battery_state", "sensor_msgs/msg/BatteryState")
        await link.subscribe("initialpose", "geometry_msgs/PoseWithCovarianceStamped", self._initial_pose)
        await link.subscribe("stop/state", "ppaas_msgs/StopState", self._stop)
        if follows_paths:
            await link.subscribe("follow_path/cancel", "actionlib_msgs/GoalID", self._cancel)
            await link.subscribe("follow_path/goal", "nav2_msgs/FollowPathActionGoal", self._follow)
        else:
            goals = "actionlib_msgs/GoalStatusArray"
            await link.subscribe("move_base/status", goals, self._goals, period=GOALS_PERIOD)
            await link.subscribe("cmd_vel", "geometry_msgs/Twist", self._velocity)

    def _velocity(self, text: bytes) -> None:
        twist = decode(Twist, text)
        self._requests.velocity(twist.linear.x, twist.angular.z)

    def _goals(self, text: bytes) -> None:
        statuses = decode(GoalStatusArray, text).status_list
        ended = {int(status) for status in Status if status.terminal}
        self._requests.goals(frozenset(each.goal_id.id for each in statuses if each.status not in ended))

    def _follow(self, text: bytes) -> None:
        goal = decode(FollowPathActionGoal, text)
        poses = [stamped.pose.planar() for stamped in goal.goal.path.poses if isinstance(stamped, PoseStamped)]
        self._requests.follow(goal.goal_id.id, route_of(poses).points)

    def _cancel(self, text: bytes) -> None:
        self._requests.cancel(decode(GoalID, text).id)

    def _initial_pose(self, text: bytes) -> None:
        self._requests.initial_pose(decode(PoseWithCovarianceStamped, text).pose.pose.planar())

    def _stop(self, text: bytes) -> None:
        self._requests.stop(decode(StopState, text).stopped)

    async def say_farewell(self) -> None:
        """Wait until what must arrive is sent, for a moment, before the robot leaves."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(FAREWELL):
                await asyncio.gather(*self._sending, return_exceptions=True)
                await self.link.drained()

    # -- publishing ----------------------------------------------------------------------------------------------------

    def motion(self, motion: VehicleMotion, deviation: float) -> None:
        """Publish where the vehicle is on the map, with the standard deviation of its position [m]."""
        stamp = _now()
        twist = Twist(Vector3(x=motion.forward, y=motion.left), Vector3(z=motion.turn))
        messages: tuple[tuple[str, Message], ...] = (
            ("odom", own_pose.odometry(motion.pose, twist, stamp)),
            ("tf", own_pose.map_to_odom(stamp)),
            ("amcl_pose", own_pose.amcl_pose(motion.pose, deviation, stamp)),
        )
        self.link.publish_together("pose", ((topic, encode(message)) for topic, message in messages))

    def scan(self, scan: LaserScan) -> None:
        """Publish a scan."""
        self.link.publish_newest("scan", encode(scan))

    def charge(self, charge: BatteryReading) -> None:
        """Publish the charge of the battery."""
        self.link.publish_newest("battery_state", msgspec.json.encode(battery_state(charge, _now())))

    def localization(self, problem: str) -> None:
        """Publish why the vehicle is not localized; empty if it is."""
        self.link.publish_newest("amcl/status", encode(String(problem)))

    def diagnostics(self, statuses: Sequence[DiagnosticStatus]) -> None:
        """Publish how the vehicle is."""
        self.link.publish_newest("diagnostics", encode(DiagnosticArray(Header(stamp=_now()), list(statuses))))

    def progress(self, progress: PathProgress) -> None:
        """Publish progress along a path."""
        message = own_pose.feedback(progress.path, progress.text, progress.distance, progress.speed, _now())
        self.link.publish_newest("follow_path/feedback", encode(message))

    def ended(self, end: PathEnded) -> None:
        """Publish the end of a path, which must arrive."""
        self._must_arrive("follow_path/result", own_pose.result(end.path, end.code, end.reason, _now()))

    def cancel_goals(self) -> None:
        """Cancel all goals of the robot, which must arrive."""
        self._must_arrive("move_base/cancel", GoalID())

    def _must_arrive(self, topic: str, message: Message) -> None:
        task = asyncio.create_task(self.link.publish(topic, encode(message)), name=topic)
        self._sending.add(task)
        task.add_done_callback(self._sent)

    def _sent(self, task: asyncio.Task[None]) -> None:
        self._sending.discard(task)
        if not task.cancelled() and task.exception() is not None:
            logger.warning("%s was not sent: %s", task.get_name(), task.exception())


def _now() -> Time:
    return Time.of(epoch())


def battery_state(charge: BatteryReading, stamp: Time) -> dict[str, Any]:
    """Return a ``sensor_msgs/BatteryState``; what is not known is null, as NaN is in JSON."""
    numbers = {"voltage": charge.voltage, "current": -charge.current, "percentage": charge.share}
    known = {name: None if math.isnan(value) else value for name, value in numbers.items()}
    return {"header": {"stamp": {"sec": stamp.secs, "nanosec": stamp.nsecs}}, **known, "present": True}
