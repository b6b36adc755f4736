"""Simulated robot that drives from goal to goal without end and records the gaps between its commands."""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from uuid import uuid4

from ppaas.clock import monotonic
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped, Twist
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from robots.client.robot_client import RobotClient
from robots.sim.courses import Course
from robots.sim.driver import Driver
from robots.sim.robot import SimulatedRobot


class RoamingRobot:
    """A driving robot that sends goals over its own connection.

    Parameters
    ----------
    client : RobotClient
        An open connection of the robot.
    robot : SimulatedRobot
        The robot in its simulated world.
    course : Course
        Its goals, which it visits in a circle.

    Attributes
    ----------
    gaps : list of float
        Times between two ``cmd_vel`` for the same goal [s].
    goals : int
        Number of goals with a result.
    drives : Event
        Set by the first ``cmd_vel``.
    """

    def __init__(self, client: RobotClient, robot: SimulatedRobot, course: Course) -> None:
        self.gaps: list[float] = []
        self.goals = 0
        self.drives = asyncio.Event()
        self._client = client
        self._driver = Driver(robot, client)
        self._course = course
        self._last: float | None = None
        self._results: asyncio.Queue[MoveBaseActionResult] = asyncio.Queue()

    async def run(self) -> None:
        """Drive until cancelled."""
        async with asyncio.TaskGroup() as group:
            group.create_task(self._driver.run())
            await self._localized()
            await self._client.subscribe("cmd_vel", Twist, self._commanded, queue_size=1)
            await self._client.subscribe("move_base/result", MoveBaseActionResult, self._arrived)
            group.create_task(self._roam())

    async def _localized(self) -> None:
        posed = await self._client.subscribe("amcl_pose", PoseWithCovarianceStamped, queue_size=1)
        await anext(posed)
        await self._client.unsubscribe(posed)

    async def _roam(self) -> None:
        while True:
            for goal in (*self._course.goals, self._course.start):
                await self._go(goal)

    async def _go(self, goal: Pose2D) -> None:
        target = PoseStamped(Header(frame_id="map"), Pose.of(goal))
        await self._client.publish("move_base/goal", MoveBaseActionGoal(MoveBaseGoal(target), GoalID(id=uuid4().hex)))
        await self._results.get()
        self.goals += 1

    def _commanded(self, _: Twist) -> None:
        now = monotonic()
        self.drives.set()
        if self._last is not None:
            self.gaps.append(now - self._last)
        self._last = now

    def _arrived(self, result: MoveBaseActionResult) -> None:
        self._last = None  # the next goal begins with planning, which is not a gap
        self._results.put_nowait(result)


@contextlib.asynccontextmanager
async def roaming_robot(
    url: str, token: str, name: str, robot: SimulatedRobot, course: Course
) -> AsyncIterator[RoamingRobot]:
    """Connect a robot and make it drive until the end of the block."""
    async with RobotClient(url, robot=name, token=token) as client:
        roamer = RoamingRobot(client, robot, course)
        task = asyncio.create_task(roamer.run())
        try:
            yield roamer
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
