"""Simulated robot that keeps driving from goal to goal during faults, and checks the messages that it receives."""

import asyncio
import itertools
import logging
from collections.abc import Callable

from benchmarks.chaos.goal_results import GoalResults
from benchmarks.chaos.message_checks import MessageChecks
from benchmarks.chaos.silences import Silences
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped, Twist
from ppaas.messages.move_base_msgs import (
    MoveBaseActionFeedback,
    MoveBaseActionGoal,
    MoveBaseActionResult,
    MoveBaseGoal,
)
from ppaas.messages.sensor_msgs import LaserScan
from robots.client.goal_tracker import TrackedGoal
from robots.client.robot_client import RobotClient
from robots.sim.courses import Course
from robots.sim.driver import Driver
from robots.sim.robot import SimulatedRobot

logger = logging.getLogger(__name__)

PATIENCE = 240.0
"""Time within which a goal must end or be reported lost [s]."""

LOOK = 0.5
"""Period at which a goal without a result is checked [s]."""

RETRY = 1.0
"""Delay before a client that gave up is replaced [s]."""


class RobotUnderTest:
    """A robot that sends goals over its own connection.

    Parameters
    ----------
    address : tuple of str
        URL of the cloud, and the token of the robot's owner.
    name : str
        Name of the robot.
    robot : SimulatedRobot
        The robot in its simulated world.
    course : Course
        Its goals, which it visits in a circle.
    tell : callable
        Called with a description of each error.
    """

    def __init__(
        self, address: tuple[str, str], name: str, robot: SimulatedRobot, course: Course, tell: Callable[[str], None]
    ) -> None:
        self.name = name
        self.goals = GoalResults(name, tell)
        self.checks = MessageChecks(name, tell)
        self.silences = Silences()
        self.sessions = 0
        self._address = address
        self._robot = robot
        self._ways = itertools.cycle((*course.goals, course.start))
        self._numbers = itertools.count(1)
        self._enough = asyncio.Event()
        self._following: TrackedGoal | None = None

    def enough(self) -> None:
        """Stop after the current goal."""
        self._enough.set()

    async def run(self) -> None:
        """Drive until ``enough`` is called; a client that gives up is replaced."""
        url, token = self._address
        while not self._enough.is_set():
            try:
                async with RobotClient(url, robot=self.name, token=token) as client:
                    await self._drive(client)
                    self.sessions += client.connections - client.resumptions
            except* PPaaSError as errors:
                logger.warning("%s: %s", self.name, errors.exceptions[0])
                self.sessions += 1
                await asyncio.sleep(RETRY)

    async def _drive(self, client: RobotClient) -> None:
        client.attach(self)
        await client.subscribe("cmd_vel", Twist, lambda _: self.checks.commanded(monotonic()))
        await client.subscribe("move_base/feedback", MoveBaseActionFeedback, self._on_feedback)
        await client.subscribe("amcl_pose", PoseWithCovarianceStamped, self._on_pose)
        await client.subscribe("move_base/result", MoveBaseActionResult, self._on_result)
        await client.subscribe("move_base/status", GoalStatusArray, self._on_status)
        async with asyncio.TaskGroup() as group:
            driving = group.create_task(Driver(self._robot, client).run())
            gave_up = group.create_task(client.closed())
            while not self._enough.is_set():
                await self._go(client, next(self._ways))
            driving.cancel()
            gave_up.cancel()

    # -- messages ------------------------------------------------------------------------------------------------------

    def published(self, topic: str, message: Message) -> bool:
        """Record a scan that the robot sends; return True, as all messages go to the cloud."""
        if isinstance(message, LaserScan):
            self.checks.scanned(message.header.stamp.seconds())
        return True

    def owns(self, topic: str) -> bool:
        """Return False: all topics come from the cloud."""
        return False

    def _on_feedback(self, message: MoveBaseActionFeedback) -> None:
        self.checks.cycled(message.header.stamp.seconds())
        self.silences.heard(monotonic())

    def _on_pose(self, message: PoseWithCovarianceStamped) -> None:
        self.checks.localized(message.header.stamp.seconds())

    def _on_status(self, message: GoalStatusArray) -> None:
        if self._following is not None:
            self._following.on_status(message, monotonic())

    def _on_result(self, message: MoveBaseActionResult) -> None:
        self.goals.result(message.status.goal_id.id)
        if self._following is not None:
            self._following.on_result(message)

    # -- one goal ------------------------------------------------------------------------------------------------------

    async def _go(self, client: RobotClient, target: Pose2D) -> None:
        goal = f"{self.name}-goal-{next(self._numbers)}"
        following = self._following = TrackedGoal(goal)
        self.goals.send(goal)
        self.checks.uncommanded.goal_sent(monotonic())
        self.silences.goal_sent(monotonic())
        pose = PoseStamped(Header(frame_id="map"), Pose.of(target))
        try:
            session = _session_of(client)
            await client.publish("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(pose), GoalID(id=goal)))
            await self._follow(client, following, session)
        except (PPaaSError, asyncio.CancelledError):
            self.goals.end("lost", "the client gave up")
            raise
        finally:
            self.checks.uncommanded.goal_ended(monotonic())
            self.silences.goal_ended(monotonic())

    async def _follow(self, client: RobotClient, following: TrackedGoal, session: int) -> None:
        began = now = monotonic()
        while now - began < PATIENCE:
            await asyncio.wait([following.result], timeout=LOOK)
            now = monotonic()
            if following.result.done():
                self.goals.end("result", Status(following.result.result().status).name)
                return
            if following.is_over(now):
                self.goals.end("status", Status(following.status.status).name)
                return
            if following.is_unknown(now):
                if _session_of(client) == session:
                    self.goals.forgotten(following.goal)
                self.goals.end("lost", "unknown to its clone")
                return
        self.goals.missing(following.goal, PATIENCE)


def _session_of(client: RobotClient) -> int:
    """Return the number of the session; messages in flight are lost when a new session begins."""
    return client.connections - client.resumptions
