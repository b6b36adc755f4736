"""Mission of one simulated robot: connects, localizes, drives to its goals, and is scored."""

import asyncio
import contextlib
import itertools
import logging
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from robots.client.move_base import GoalOutcome, MoveBaseClient
from robots.client.robot_client import RobotClient
from robots.demo.options import Write, no_lines
from robots.demo.report import RobotReport
from robots.demo.scorer import Scored, Scorer
from robots.sim.courses import Course
from robots.sim.driver import Driver

logger = logging.getLogger(__name__)

SLOWEST = 0.15
"""Average speed below which a goal times out [m/s]."""

ALLOWANCE = 45.0
"""Time per goal for planning, turning and recoveries, in addition to the driving time [s]."""


@dataclass(slots=True)
class MissionProgress:
    """Progress of a mission, for display."""

    robot: str
    state: str = "waiting"
    goal: int = 0
    goals: int = 0
    target: Pose2D | None = None


@dataclass(slots=True)
class Mission:
    """Mission of one robot.

    Parameters
    ----------
    world : World or SimulatedBuilding
        World that contains the robot.
    index : int
        Index of the robot in the world.
    robot : str
        Id of the robot in the cloud.
    course : Course
        Start and goals.
    write : callable
        Writes a line about each step of the robot; none is written by default.
    """

    world: Scored
    index: int
    robot: str
    course: Course
    write: Write = no_lines
    report: RobotReport = field(init=False)
    progress: MissionProgress = field(init=False)

    def __post_init__(self) -> None:
        self.report = RobotReport(self.robot, goals_asked=len(self.course.goals))
        self.progress = MissionProgress(self.robot, goals=len(self.course.goals))

    async def run(self, url: str, token: str, *, keep_going: bool = False) -> None:
        """Drive the course; with ``keep_going``, repeat it until cancelled.

        An error of the cloud ends the mission. It is logged, and the remaining goals count as not reached.
        """
        try:
            async with self._connected(url, token) as move_base:
                await self._drive(move_base, keep_going)
            self.progress.state = "done"
        except* PPaaSError as errors:
            reason = errors.exceptions[0]
            logger.error("%s: %s", self.robot, reason)
            self.progress.state = f"failed: {reason}"

    @contextlib.asynccontextmanager
    async def _connected(self, url: str, token: str) -> AsyncIterator[MoveBaseClient]:
        """Connect the robot and its operator, and wait until the robot is localized."""
        self.progress.state = "connecting"
        began = monotonic()
        async with (
            RobotClient(url, robot=self.robot, token=token) as client,
            asyncio.TaskGroup() as group,
            RobotClient(url, robot=self.robot, token=token, role="operator") as operator,
        ):
            driving = group.create_task(Driver(self.world.robots[self.index], client).run())
            move_base = await MoveBaseClient(operator).start()
            self.progress.state = "localizing"
            await move_base.localized()
            self.report.ready_seconds = round(monotonic() - began, 4)
            self.write(f"{self.robot} is localized, {self.report.ready_seconds:.1f} s after it connected")
            yield move_base
            driving.cancel()

    async def _drive(self, move_base: MoveBaseClient, keep_going: bool) -> None:
        goals = self.course.goals
        self.report.goals_asked = 0 if keep_going else len(goals)
        rounds = itertools.cycle((*goals, self.course.start)) if keep_going else iter(goals)
        for number, goal in enumerate(rounds, start=1):
            # The paths of a round trip are not those of the course, but at most three times as long as its longest one.
            length = 3.0 * max(self.course.lengths) if keep_going else self.course.lengths[number - 1]
            await self._go(move_base, number, goal, ALLOWANCE + length / SLOWEST)

    async def _go(self, move_base: MoveBaseClient, number: int, goal: Pose2D, timeout: float) -> None:
        self.progress.goal, self.progress.target, self.progress.state = number, goal, "driving"
        outcome = await self.go(move_base, number, goal, timeout)
        error = Scorer(self.world).error(self.index, goal)
        self.report.goals_asked = max(number, self.report.goals_asked)
        self.report.add_goal(outcome.reached, error, outcome.plan_seconds)
        if outcome.reached:
            self.write(f"{self.robot} has reached goal {number}, {error:.2f} m off")
        else:
            logger.warning("%s: goal %d: %s: %s", self.robot, number, outcome.status.name, outcome.text)

    async def go(self, move_base: MoveBaseClient, number: int, goal: Pose2D, timeout: float) -> GoalOutcome:
        """Send the robot to the goal of a number, from 1, and wait until that has ended, up to a time [s]."""
        return await move_base.go(goal, timeout)

    def close(self) -> RobotReport:
        """Return the report, completed with the true distance and the contacts."""
        scorer = Scorer(self.world)
        self.report.distance_m = round(scorer.distance(self.index), 3)
        self.report.collisions = scorer.collisions(self.index)
        return self.report
