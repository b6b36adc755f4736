"""Client of the action ``explore``: sends a goal, reports its feedback, and waits for its result."""

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.messages.actionlib_msgs import GoalID, GoalStatusArray, Status
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.explore_msgs import (
    ExploreActionFeedback,
    ExploreActionGoal,
    ExploreActionResult,
    ExploreFeedback,
    ExploreGoal,
    ExploreResult,
)
from robots.client.move_base import TrackedGoal
from robots.client.robot_client import RobotClient

ANSWER_TIMEOUT = 15.0
"""Time within which the node must report the goal [s]."""

CANCEL_TIMEOUT = 5.0
"""Time to wait for the result of a cancelled goal [s]."""


@dataclass(frozen=True, slots=True)
class ExploreOutcome:
    """Outcome of a goal: its status, the node's explanation, and its result if one has come."""

    status: Status
    text: str
    result: ExploreResult


class ExploreClient:
    """Lets one robot explore.

    Parameters
    ----------
    client : RobotClient
        Connected client in the role of an operator.
    on_feedback : callable, optional
        Called with each feedback.
    clock, stamp_clock : callable
        Monotonic seconds; seconds since the epoch.
    """

    def __init__(
        self,
        client: RobotClient,
        on_feedback: Callable[[ExploreFeedback], None] | None = None,
        clock: Clock = monotonic,
        stamp_clock: Clock = epoch,
    ) -> None:
        self._client, self._on_feedback = client, on_feedback
        self._clock, self._stamp_clock = clock, stamp_clock
        self._tracker = TrackedGoal(uuid4().hex)
        self._answered = asyncio.Event()
        self._last = ExploreResult()

    async def explore(self, *, return_to_start: bool = False, answer_timeout: float = ANSWER_TIMEOUT) -> ExploreOutcome:
        """Send a goal and wait for its outcome. If the coroutine is cancelled, so is the goal.

        Parameters
        ----------
        return_to_start : bool
            Whether the robot drives back when no frontier is left.
        answer_timeout : float
            Time within which the node must report the goal [s].

        Raises
        ------
        Unavailable
            The clone of the robot has no node ``explore``, or it does not know the goal any more.
        PPaaSError
            The client has lost its connection for good.
        """
        await self._subscribe()
        goal_id = GoalID(Time.of(self._stamp_clock()), self._tracker.goal)
        await self._client.publish("explore/goal", ExploreActionGoal(ExploreGoal(return_to_start), goal_id))
        try:
            await self._first(self._answered.wait(), answer_timeout)
            return await self._outcome()
        except asyncio.CancelledError:
            await self._cancel()
            raise

    async def _subscribe(self) -> None:
        client = self._client
        await client.subscribe("explore/result", ExploreActionResult, self._on_result)
        await client.subscribe("explore/status", GoalStatusArray, self._on_status, queue_size=1)
        await client.subscribe("explore/feedback", ExploreActionFeedback, self._take_feedback, queue_size=10)

    async def _outcome(self) -> ExploreOutcome:
        await self._first(self._tracker.result, None)
        status = self._tracker.result.result()
        if status.status == Status.LOST:
            await self._publish_cancel()
            raise Unavailable("the clone of the robot does not know the goal any more; explore again")
        return ExploreOutcome(Status(status.status), status.text, self._last)

    async def _first(self, awaited: Any, timeout: float | None) -> None:
        """Wait for something, and raise if the client fails meanwhile or the time is up."""
        waiting, failed = asyncio.ensure_future(awaited), asyncio.ensure_future(self._client.closed())
        try:
            done, _ = await asyncio.wait({waiting, failed}, timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
            if failed in done and waiting not in done:
                failed.result()
            if not done:
                await self._publish_cancel()  # a node that answers late must not drive the robot
                raise Unavailable(
                    f"no answer within {timeout:g} s: the robot has no node 'explore'; its robot file must name a "
                    "new map ('map=new:NAME'), and the robot must connect again after a change"
                )
        finally:
            failed.cancel()
            if waiting is not self._tracker.result:
                waiting.cancel()

    async def _cancel(self) -> None:
        await self._publish_cancel()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.shield(self._tracker.result), CANCEL_TIMEOUT)

    async def _publish_cancel(self) -> None:
        await self._client.publish("explore/cancel", GoalID(id=self._tracker.goal))

    # -- messages ------------------------------------------------------------------------------------------------------

    def _on_result(self, message: ExploreActionResult) -> None:
        if message.status.goal_id.id == self._tracker.goal and not self._tracker.result.done():
            self._last = message.result
            self._tracker.result.set_result(message.status)
            self._answered.set()

    def _on_status(self, message: GoalStatusArray) -> None:
        self._tracker.on_status(message, self._clock())
        if self._tracker.result.done() or any(each.goal_id.id == self._tracker.goal for each in message.status_list):
            self._answered.set()

    def _take_feedback(self, message: ExploreActionFeedback) -> None:
        if message.status.goal_id.id != self._tracker.goal:
            return
        self._answered.set()
        now = message.feedback
        self._last = ExploreResult(now.frontiers, now.unreachable, now.area, now.distance, now.exploration_time)
        if self._on_feedback is not None:
            self._on_feedback(now)
