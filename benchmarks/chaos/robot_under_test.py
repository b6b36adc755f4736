"""Simulated robot that keeps driving during faults, and checks the messages that it receives."""

import asyncio
import logging
import math
from collections.abc import Callable, Sequence

from benchmarks.chaos.goal_sender import GoalSender, Standing
from benchmarks.chaos.message_checks import MessageChecks, Silences, Strays
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import Point, PoseWithCovarianceStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionFeedback
from ppaas.messages.sensor_msgs import LaserScan
from robots.client.robot_client import RobotClient
from robots.sim.courses import Course
from robots.sim.driver import Driver
from robots.sim.robot import SimulatedRobot

logger = logging.getLogger(__name__)

RETRY = 1.0
"""Delay before a client that gave up is replaced [s]."""


class RobotUnderTest:
    """A robot that drives from goal to goal.

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
    clock : callable
        Returns the time of its world [s].
    operator : bool
        Whether an operator with a connection of its own sends the goals, instead of the robot.

    Attributes
    ----------
    ended : Event
        Set once ``enough`` was called and the last goal has ended.
    """

    def __init__(
        self,
        address: tuple[str, str],
        name: str,
        robot: SimulatedRobot,
        course: Course,
        tell: Callable[[str], None],
        *,
        clock: Callable[[], float],
        operator: bool = False,
    ) -> None:
        self.name = name
        self.checks = MessageChecks(name, tell)
        self.silences = Silences()
        self.strays = Strays()
        sender = f"operator-of-{name}" if operator else name
        expecting = self.checks.uncommanded, self.silences
        self.sender = GoalSender(sender, (*course.goals, course.start), expecting, self.standing, tell)
        self.sessions = 0
        self._operator = operator
        self._address = address
        self._robot = robot
        self._clock = clock
        self._believed: Pose2D | Point = course.start
        self.ended = asyncio.Event()
        self._left = asyncio.Event()

    def enough(self) -> None:
        """Stop after the current goal, and stay connected."""
        self.sender.enough()

    def leave(self) -> None:
        """Disconnect, and end ``run``."""
        self.strays.end(monotonic())
        self._left.set()

    async def run(self) -> None:
        """Drive until ``leave`` is called; a client that gives up is replaced.

        A robot that has ended its last goal stays connected, so that it can give way to others.
        """
        async with asyncio.TaskGroup() as group:
            group.create_task(self._run_robot())
            if self._operator:
                group.create_task(self._run_operator())

    def standing(self) -> Standing:
        """Return the position of the robot, and the numbers of commands and cycles."""
        pose = self._robot.base.pose
        lost = math.hypot(pose.x - self._believed.x, pose.y - self._believed.y)
        return Standing(pose.x, pose.y, lost, self._clock(), self.checks.commands, self.checks.cycles)

    async def _run_robot(self) -> None:
        url, token = self._address
        while not self._left.is_set():
            try:
                async with RobotClient(url, robot=self.name, token=token) as client:
                    await self._drive(client)
                    self.sessions += client.connections - client.resumptions
            except* PPaaSError as errors:
                logger.warning("%s: %s", self.name, errors.exceptions[0])
                self.sessions += 1
                await asyncio.sleep(RETRY)

    async def _run_operator(self) -> None:
        url, token = self._address
        while not self.sender.is_over:
            try:
                async with RobotClient(url, robot=self.name, token=token, role="operator") as client:
                    await self._operate(client)
            except* PPaaSError as errors:
                logger.warning("operator of %s: %s", self.name, errors.exceptions[0])
                await asyncio.sleep(RETRY)
        self.ended.set()

    async def _operate(self, client: RobotClient) -> None:
        async with asyncio.TaskGroup() as group:
            gave_up = group.create_task(client.closed())
            await self.sender.run(client)
            gave_up.cancel()

    async def _drive(self, client: RobotClient) -> None:
        client.attach(self)
        await client.subscribe("cmd_vel", Twist, lambda _: self.checks.commanded(monotonic()))
        await client.subscribe("move_base/feedback", MoveBaseActionFeedback, self._on_feedback)
        await client.subscribe("amcl_pose", PoseWithCovarianceStamped, self._on_pose)
        async with asyncio.TaskGroup() as group:
            driving = group.create_task(Driver(self._robot, client).run())
            gave_up = group.create_task(client.closed())
            if not self._operator:
                await self.sender.run(client)
                self.ended.set()
            await self._left.wait()
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
        self._believed = message.pose.pose.position
        self.strays.look(self.standing().lost, monotonic())


async def end_together(robots: Sequence[RobotUnderTest]) -> None:
    """End the runs of robots once each has ended its current goal.

    Until then all stay connected: one that left sooner would stand in the way of others and not give way to them.
    """
    for robot in robots:
        robot.enough()
    await asyncio.gather(*(robot.ended.wait() for robot in robots))
    for robot in robots:
        robot.leave()
