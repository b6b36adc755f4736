"""The operator's side of Move Base: sends goals and follows what becomes of them."""

import asyncio
import math
from dataclasses import dataclass
from typing import Any, Self
from uuid import uuid4

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav_msgs import Path
from ppaas.messages.std_msgs import Header, Time
from robots.client.goal_tracker import Following
from robots.client.robot_client import RobotClient


@dataclass(frozen=True, slots=True)
class GoalOutcome:
    """What became of a goal.

    Parameters
    ----------
    status : Status
        ``SUCCEEDED``, ``ABORTED`` …; ``LOST`` where no result came in time, or nobody knows the goal any more.
    text : str
        Move Base's.
    seconds : float
        From the goal sent to the result.
    plan_seconds : float
        From the goal sent to the first plan; NaN if none came.
    """

    status: Status
    text: str
    seconds: float
    plan_seconds: float

    @property
    def reached(self) -> bool:
        """Tell whether Move Base says that the robot is there."""
        return self.status is Status.SUCCEEDED


class MoveBaseClient:
    """Sends goals to one robot, one at a time.

    Parameters
    ----------
    client : RobotClient
        Open, in the role of an operator.
    clock, stamp_clock : callable
        Monotonic seconds; seconds since the epoch.
    """

    def __init__(self, client: RobotClient, clock: Clock = monotonic, stamp_clock: Clock = epoch) -> None:
        self._client = client
        self._clock = clock
        self._stamp_clock = stamp_clock
        self._following: Following | None = None
        self._planned: float | None = None
        self._posed = asyncio.Event()
        self.estimate: Pose2D | None = None

    async def start(self) -> Self:
        """Subscribe to what tells how a goal goes."""
        await self._client.subscribe("move_base/result", MoveBaseActionResult, self._on_result)
        await self._client.subscribe("move_base/status", GoalStatusArray, self._on_status, queue_size=1)
        await self._client.subscribe("plan", Path, self._on_plan, queue_size=1)
        await self._client.subscribe("amcl_pose", PoseWithCovarianceStamped, self._on_pose, queue_size=1)
        return self

    async def localized(self, timeout: float = 30.0) -> Pose2D:
        """Wait for the first pose that localization gives, and return it.

        Raises
        ------
        Unavailable
            None came in time.
        """
        try:
            async with asyncio.timeout(timeout):
                await self._posed.wait()
        except TimeoutError as error:
            raise Unavailable(f"localization gave no pose in {timeout:g} s; do scans and odometry arrive?") from error
        assert self.estimate is not None
        return self.estimate

    async def go(self, target: Pose2D, timeout: float = 120.0) -> GoalOutcome:
        """Send a goal and wait for what becomes of it.

        Parameters
        ----------
        target : Pose2D
            In the frame ``map``.
        timeout : float
            Seconds after which the goal is cancelled and counts as lost.

        Raises
        ------
        PPaaSError
            The client gave up.
        """
        stamp = Time.of(self._stamp_clock())
        header = Header(stamp=stamp, frame_id="map")
        following = self._following = Following(uuid4().hex)
        self._planned = None
        pose = PoseStamped(header, Pose.of(target))
        sent = self._clock()
        await self._client.publish(
            "move_base/goal", MoveBaseActionGoal(MoveBaseGoal(pose), GoalID(stamp, following.goal), header)
        )
        status = await self._wait(following, timeout)
        return GoalOutcome(
            status=Status(status.status),
            text=status.text,
            seconds=self._clock() - sent,
            plan_seconds=math.nan if self._planned is None else self._planned - sent,
        )

    async def _wait(self, following: Following, timeout: float) -> GoalStatus:
        """Return how the goal ended; a client that gives up ends the waiting."""
        gave_up = asyncio.ensure_future(self._client.closed())
        either: set[asyncio.Future[Any]] = {following.result, gave_up}
        try:
            await asyncio.wait(either, timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
            if not following.result.done() and gave_up.done():
                gave_up.result()
            status = following.result.result() if following.result.done() else _lost(following, f"in {timeout:g} s")
            if status.status == Status.LOST:
                await self._client.publish("move_base/cancel", GoalID(id=following.goal))
            return status
        finally:
            gave_up.cancel()

    def _on_result(self, message: MoveBaseActionResult) -> None:
        if self._following is not None:
            self._following.ended(message)

    def _on_status(self, message: GoalStatusArray) -> None:
        following, now = self._following, self._clock()
        if following is None or following.result.done():
            return
        following.listed(message, now)
        if following.is_over(now):
            following.result.set_result(following.status)
        elif following.is_unknown(now):
            following.result.set_result(_lost(following, "and its clone does not know the goal: send it again"))

    def _on_plan(self, message: Path) -> None:
        # A plan is published while a goal is under way and no other time; an empty one says that there is none.
        if self._following is not None and self._planned is None and message.poses:
            self._planned = self._clock()

    def _on_pose(self, message: PoseWithCovarianceStamped) -> None:
        self.estimate = message.pose.pose.planar()
        self._posed.set()


def _lost(following: Following, why: str) -> GoalStatus:
    return GoalStatus(GoalID(id=following.goal), Status.LOST, f"no result {why}")
