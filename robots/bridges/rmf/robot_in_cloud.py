"""Robot of a fleet for Open-RMF in the cloud: executes its commands, and reports its pose, battery and drives."""

import asyncio
import logging
import math
from collections.abc import Callable, Coroutine
from typing import Any, NoReturn

import msgspec

from ppaas.clock import monotonic
from ppaas.decoding import from_json
from ppaas.errors import PPaaSError, Unavailable
from ppaas.messages import decode, encode
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.std_msgs import Bool
from ppaas.messages.geometry_msgs import Pose, PoseWithCovarianceStamped
from ppaas.messages.nav2_msgs import SpeedLimit
from ppaas.wire.own_topics import OWN_TOPICS, PRESENCE
from ppaas.wire.rmf.fleet_robot import DriveThrough, FleetRobot, RobotCommand
from robots.bridges.core.battery import CHARGING, charge_of
from robots.bridges.core.cloud_link import LOST, CloudGoal, CloudLink

logger = logging.getLogger(__name__)

POSE_PERIOD = 0.2
"""Least time between two poses [s]."""

BATTERY_PERIOD = 1.0
"""Least time between two messages of the battery [s]."""

POSE_AGE = 3.0
"""Age of the last pose from which the robot counts as lost [s]."""

REACHED = 4
"""Status of a goal that was reached, as ROS 2 numbers it."""

THROUGH = "nav2_msgs/action/NavigateThroughPoses"


class _Progress(msgspec.Struct):
    """Feedback of the action, as far as it is used."""

    number_of_poses_remaining: int = 0


class RobotInCloud:
    """Stays connected to one robot.

    Parameters
    ----------
    robot : FleetRobot
    link : callable
        Returns a new link to the robot's clone.
    now : callable
        Clock of Open-RMF [s].
    """

    def __init__(self, robot: FleetRobot, link: Callable[[], CloudLink], now: Callable[[], float]) -> None:
        self._robot, self._new_link, self._now = robot, link, now
        self._link: CloudLink | None = None
        self._goal: CloudGoal | None = None
        self._posed = -math.inf
        self._here = True
        self._speed = 0.0
        self._stray = False
        self._commands: asyncio.Queue[RobotCommand] = asyncio.Queue()
        self._tasks: set[asyncio.Task[None]] = set()

    async def run(self) -> NoReturn:
        """Follow the robot until cancelled.

        Raises
        ------
        PPaaSError
            The cloud refuses the token for this robot, and why.
        """
        try:
            while True:
                link = self._link = self._new_link()
                try:
                    async with link:
                        logger.info("robot %s is in the fleet", self._robot.name)
                        await self._subscribe(link)
                        self._start(self._execute(link))
                        await link.closed()
                except Unavailable as error:
                    logger.info("robot %s is awaited: %s", self._robot.name, error)
                finally:
                    await self._end_tasks()
                    self._forget_drive()
        finally:
            await self._end_tasks()

    def look(self) -> None:
        """Do what is due: lose the pose when none comes, go on with the path, and queue the robot's commands."""
        if monotonic() - self._posed > POSE_AGE or not self._here:
            self._robot.pose = None
        if self._link is not None and self._link.connected:
            self._robot.advance(self._now())
        for command in self._robot.take_commands():
            self._commands.put_nowait(command)

    # -- from the robot ------------------------------------------------------------------------------------------------

    async def _subscribe(self, link: CloudLink) -> None:
        kind = "geometry_msgs/PoseWithCovarianceStamped"
        await link.subscribe(PRESENCE, OWN_TOPICS[PRESENCE], self._presence_received)
        await link.subscribe("amcl_pose", kind, self._pose_received, period=POSE_PERIOD)
        await link.subscribe("battery_state", "sensor_msgs/msg/BatteryState", self._charged, period=BATTERY_PERIOD)

    def _presence_received(self, message: bytes) -> None:
        self._here = decode(Bool, message).data

    def _pose_received(self, message: bytes) -> None:
        self._robot.pose = decode(PoseWithCovarianceStamped, message).pose.pose.planar()
        self._posed = monotonic()

    def _charged(self, message: bytes) -> None:
        charge = charge_of(message)
        if charge is not None and charge.percentage is not None:
            self._robot.battery = min(max(100.0 * charge.percentage, 0.0), 100.0)
            self._robot.charging = charge.power_supply_status == CHARGING

    # -- to the robot --------------------------------------------------------------------------------------------------

    async def _execute(self, link: CloudLink) -> None:
        if self._stray:
            await self._cancel_stray(link)
        while True:
            command = await self._commands.get()
            if isinstance(command, DriveThrough):
                await self._drive(link, command)
            elif self._goal is not None:
                await link.cancel_goal(self._goal)
                self._goal = None

    async def _drive(self, link: CloudLink, drive: DriveThrough) -> None:
        if drive.speed != self._speed:
            self._speed = drive.speed
            await link.publish("speed_limit", encode(SpeedLimit(drive.speed)))
        poses = [{"header": {"frame_id": "map"}, "pose": Pose.of(pose)} for pose in drive.poses]

        def progressed(feedback: bytes) -> None:
            self._robot.drive_passed(drive.number, from_json(feedback, _Progress).number_of_poses_remaining)

        goal = await link.send_goal(
            "navigate_through_poses", THROUGH, msgspec.json.encode({"poses": poses}), progressed
        )
        self._goal = goal
        self._start(self._await_end(link, drive.number, goal))

    async def _await_end(self, link: CloudLink, number: int, goal: CloudGoal) -> None:
        end = await goal.end
        if end.reason == LOST:
            await self._cancel_stray(link)  # also of a drive that ends: its cancellation was lost as well
        if goal is not self._goal:
            return
        self._goal = None
        if end.reason == LOST:
            self._robot.drive_lost()
        elif end.status == REACHED:
            self._robot.drive_ended(number, self._now(), reached=True)
        else:
            text = end.reason or _message(end.result)
            logger.warning("robot %s does not reach its waypoint: %s", self._robot.name, text)
            self._robot.drive_ended(number, self._now(), reached=False, text=text)

    def _forget_drive(self) -> None:
        """Forget the drive and the commands of a link that has ended; the clone may still drive."""
        while not self._commands.empty():
            self._commands.get_nowait()
        self._stray |= self._goal is not None
        self._goal = None
        self._robot.drive_lost()

    async def _cancel_stray(self, link: CloudLink) -> None:
        """Cancel the goal of a session that has ended, whose name nobody knows: an empty name means all goals."""
        self._stray = False
        await link.publish("move_base/cancel", encode(GoalID()))

    def _start(self, work: Coroutine[Any, Any, None]) -> None:
        task = asyncio.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and isinstance(error := task.exception(), PPaaSError):
            logger.warning("robot %s: %s", self._robot.name, error)

    async def _end_tasks(self) -> None:
        tasks = list(self._tasks)
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)


def _message(result: bytes) -> str:
    """Return what a result of Nav2 says of a failure."""
    values = msgspec.json.decode(result)
    text = str(values.get("error_msg") or "") if isinstance(values, dict) else ""
    return text or "another client cancelled or replaced its goal"
