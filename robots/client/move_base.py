"""Move Base client of an operator: sends goals and waits for their results.

A result message is lost if the cloud was killed, or if the robot's session ended before the result was delivered. Move
Base publishes the status list periodically, so the tracker can still learn how the goal ended, or that Move Base does
not know it any more (see `ppaas.navigation.goal_watch`).
"""

import asyncio
import math
from dataclasses import dataclass
from typing import Any, Self
from uuid import uuid4

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped
from ppaas.messages.move_base_msgs import MoveBaseActionGoal, MoveBaseActionResult, MoveBaseGoal
from ppaas.messages.nav_msgs import Path
from ppaas.navigation.goal_watch import GoalWatch
from robots.client.robot_client import RobotClient


class TrackedGoal:
    """State of one goal.

    Parameters
    ----------
    goal : str
        Id of the goal.

    Attributes
    ----------
    result : Future
        Final status; set when the goal has ended, by its result or by the lists. `Status.LOST` if it is not known any
        more.
    has_result : bool
        Whether it ended by its result.
    """

    def __init__(self, goal: str) -> None:
        self.goal = goal
        self.result: asyncio.Future[GoalStatus] = asyncio.get_running_loop().create_future()
        self.has_result = False
        self._watch = GoalWatch(goal)

    @property
    def status(self) -> GoalStatus:
        """Status in the last list that contained the goal."""
        return GoalStatus(GoalID(id=self.goal), self._watch.status, self._watch.text)

    def on_result(self, message: MoveBaseActionResult) -> None:
        """Process a result; results of other goals are ignored."""
        if message.status.goal_id.id == self.goal and not self.result.done():
            self.has_result = True
            self.result.set_result(message.status)

    def on_status(self, message: GoalStatusArray, now: float) -> None:
        """Process a status list received at the monotonic time ``now`` [s]."""
        end = self._watch.see(message.status_list, now)
        if end is not None and not self.result.done():
            self.result.set_result(GoalStatus(GoalID(id=self.goal), end, self._watch.text))


@dataclass(frozen=True, slots=True)
class GoalOutcome:
    """Outcome of a goal.

    Parameters
    ----------
    status : Status
        ``SUCCEEDED``, ``ABORTED`` …; ``LOST`` if no result arrived in time, or Move Base does not know the goal.
    text : str
        Move Base's explanation.
    seconds : float
        Time from sending the goal to its result [s].
    plan_seconds : float
        Time from sending the goal to the first plan [s]; NaN if there was no plan.
    """

    status: Status
    text: str
    seconds: float
    plan_seconds: float

    @property
    def reached(self) -> bool:
        """Return whether Move Base reported success."""
        return self.status is Status.SUCCEEDED


class MoveBaseClient:
    """Sends goals to one robot, one after the other.

    Parameters
    ----------
    client : RobotClient
        Connected client in the role of an operator.
    clock, stamp_clock : callable
        Monotonic seconds; seconds since the epoch.
    """

    def __init__(self, client: RobotClient, clock: Clock = monotonic, stamp_clock: Clock = epoch) -> None:
        self._client = client
        self._clock = clock
        self._stamp_clock = stamp_clock
        self._tracker: TrackedGoal | None = None
        self._planned: float | None = None
        self._posed = asyncio.Event()
        self.estimate: Pose2D | None = None

    async def start(self) -> Self:
        """Subscribe to results, statuses, plans and the estimated pose."""
        await self._client.subscribe("move_base/result", MoveBaseActionResult, self._on_result)
        await self._client.subscribe("move_base/status", GoalStatusArray, self._on_status, queue_size=1)
        await self._client.subscribe("plan", Path, self._on_plan, queue_size=1)
        await self._client.subscribe("amcl_pose", PoseWithCovarianceStamped, self._on_pose, queue_size=1)
        return self

    async def localized(self, timeout: float = 30.0) -> Pose2D:
        """Wait for the first pose estimate of localization, and return it.

        Raises
        ------
        Unavailable
            There was no estimate within ``timeout`` seconds.
        """
        try:
            async with asyncio.timeout(timeout):
                await self._posed.wait()
        except TimeoutError as error:
            raise Unavailable(
                f"no pose estimate within {timeout:g} s; check that the robot publishes scan and odom"
            ) from error
        assert self.estimate is not None
        return self.estimate

    async def go(self, target: Pose2D, timeout: float = 120.0) -> GoalOutcome:
        """Send a goal and wait for its outcome.

        Parameters
        ----------
        target : Pose2D
            Goal in the frame ``map``.
        timeout : float
            Time after which the goal is cancelled and counts as lost [s].

        Raises
        ------
        PPaaSError
            The client has lost its connection for good.
        """
        stamp = Time.of(self._stamp_clock())
        header = Header(stamp=stamp, frame_id="map")
        tracker = self._tracker = TrackedGoal(uuid4().hex)
        self._planned = None
        pose = PoseStamped(header, Pose.of(target))
        sent = self._clock()
        await self._client.publish(
            "move_base/goal", MoveBaseActionGoal(MoveBaseGoal(pose), GoalID(stamp, tracker.goal), header)
        )
        status = await self._wait(tracker, timeout)
        return GoalOutcome(
            status=Status(status.status),
            text=status.text,
            seconds=self._clock() - sent,
            plan_seconds=math.nan if self._planned is None else self._planned - sent,
        )

    async def _wait(self, tracker: TrackedGoal, timeout: float) -> GoalStatus:
        """Return the final status of the goal; raise if the client fails meanwhile."""
        failed = asyncio.ensure_future(self._client.closed())
        either: set[asyncio.Future[Any]] = {tracker.result, failed}
        try:
            await asyncio.wait(either, timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
            if not tracker.result.done() and failed.done():
                failed.result()
            lost = GoalStatus(GoalID(id=tracker.goal), Status.LOST, f"no result within {timeout:g} s")
            status = tracker.result.result() if tracker.result.done() else lost
            if status.status == Status.LOST:
                await self._cancel(tracker)
            return status
        finally:
            failed.cancel()

    async def cancel(self) -> None:
        """Cancel the goal that was sent last, unless its outcome is known; other goals of the robot go on.

        Raises
        ------
        PPaaSError
            The client has lost its connection for good.
        """
        if self._tracker is not None and not self._tracker.result.done():
            await self._cancel(self._tracker)

    async def _cancel(self, tracker: TrackedGoal) -> None:
        await self._client.publish("move_base/cancel", GoalID(id=tracker.goal))

    def _on_result(self, message: MoveBaseActionResult) -> None:
        if self._tracker is not None:
            self._tracker.on_result(message)

    def _on_status(self, message: GoalStatusArray) -> None:
        if self._tracker is not None:
            self._tracker.on_status(message, self._clock())

    def _on_plan(self, message: Path) -> None:
        # Move Base publishes plans only while a goal is active; an empty path means that it found none.
        if self._tracker is not None and self._planned is None and message.poses:
            self._planned = self._clock()

    def _on_pose(self, message: PoseWithCovarianceStamped) -> None:
        self.estimate = message.pose.pose.planar()
        self._posed.set()
