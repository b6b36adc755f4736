"""What one simulated robot does with the cloud: connect, localize, and drive to its goals under the scorer's eyes."""

import asyncio
import contextlib
import itertools
import logging
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from robots.client.move_base import MoveBaseClient
from robots.client.robot_client import RobotClient
from robots.demo.report import RobotReport
from robots.demo.scorer import Scorer
from robots.sim.courses import Course
from robots.sim.driver import Driver
from robots.sim.world import World

logger = logging.getLogger(__name__)

SLOWEST = 0.15
"""A goal is given up when the robot was slower than this over its whole way [m/s]."""

PATIENCE = 45.0
"""… and beside that, seconds for planning, turning and recoveries."""


@dataclass(slots=True)
class MissionProgress:
    """How far a robot is, for those who watch."""

    robot: str
    state: str = "waiting"
    goal: int = 0
    goals: int = 0
    target: Pose2D | None = None


@dataclass(slots=True)
class Mission:
    """One robot's course.

    Parameters
    ----------
    world : World
        With the robot in it.
    index : int
        Of the robot in the world.
    robot : str
        Its id in the cloud.
    course : Course
        Where it goes.
    """

    world: World
    index: int
    robot: str
    course: Course
    report: RobotReport = field(init=False)
    progress: MissionProgress = field(init=False)

    def __post_init__(self) -> None:
        self.report = RobotReport(self.robot, goals_asked=len(self.course.goals))
        self.progress = MissionProgress(self.robot, goals=len(self.course.goals))

    async def run(self, url: str, token: str, *, keep_going: bool = False) -> None:
        """Drive the course; with ``keep_going`` again and again, until cancelled.

        An error of the cloud ends the mission: it is logged, and the goals that were not reached tell of it.
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
        """Connect the robot and its operator, and wait until the cloud knows where the robot is."""
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
            yield move_base
            driving.cancel()

    async def _drive(self, move_base: MoveBaseClient, keep_going: bool) -> None:
        goals = self.course.goals
        self.report.goals_asked = 0 if keep_going else len(goals)
        rounds = itertools.cycle((*goals, self.course.start)) if keep_going else iter(goals)
        for number, goal in enumerate(rounds, start=1):
            # On a round trip there are other ways than the course's; none is longer than three times one of these.
            way = 3.0 * max(self.course.lengths) if keep_going else self.course.lengths[number - 1]
            await self._go(move_base, number, goal, PATIENCE + way / SLOWEST)

    async def _go(self, move_base: MoveBaseClient, number: int, goal: Pose2D, patience: float) -> None:
        self.progress.goal, self.progress.target, self.progress.state = number, goal, "driving"
        outcome = await move_base.go(goal, patience)
        error = Scorer(self.world).error(self.index, goal)
        self.report.goals_asked = max(number, self.report.goals_asked)
        self.report.add_goal(outcome.reached, error, outcome.plan_seconds)
        if not outcome.reached:
            logger.warning("%s: goal %d: %s: %s", self.robot, number, outcome.status.name, outcome.text)

    def close(self) -> RobotReport:
        """Return the report, with what the scorer saw on the whole way."""
        scorer = Scorer(self.world)
        self.report.distance_m = round(scorer.distance(self.index), 3)
        self.report.collisions = scorer.collisions(self.index)
        return self.report
