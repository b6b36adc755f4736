"""Client of an action that a clone serves by the topics of ROS 1: sends a goal, reports feedback, waits for the result.

Move Base's own client is `robots.client.move_base`, which sends many goals.
"""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any, Generic, TypeVar
from uuid import uuid4

from ppaas.clock import Clock, epoch, monotonic
from ppaas.errors import Unavailable
from ppaas.messages.actionlib_msgs import GoalID, GoalStatus, GoalStatusArray, Status
from ppaas.messages.base.message import Message
from ppaas.messages.base.std_msgs import Time
from ppaas.nodes.nav2_actions import Nav2ActionTopics
from robots.client.move_base import TrackedGoal
from robots.client.robot_client import RobotClient

F = TypeVar("F", bound=Message)
R = TypeVar("R", bound=Message)

ANSWER_TIMEOUT = 15.0
"""Time within which the node must report the goal [s]."""

CANCEL_TIMEOUT = 5.0
"""Time to wait for the result of a cancelled goal [s]."""


class ActionClient(Generic[F, R]):
    """Sends one goal of an action.

    Parameters
    ----------
    client : RobotClient
        Connected client in the role of an operator.
    topics : Nav2ActionTopics
        Topics of the action.
    lacking : str
        What a robot without the node lacks, for the error.
    on_feedback : callable, optional
        Called with each feedback.
    clock, stamp_clock : callable
        Monotonic seconds; seconds since the epoch.
    """

    def __init__(
        self, client: RobotClient, topics: Nav2ActionTopics, *, lacking: str,
        on_feedback: Callable[[F], None] | None = None, clock: Clock = monotonic, stamp_clock: Clock = epoch,
    ) -> None:  # fmt: skip
        self._client, self._topics, self._lacking, self._on_feedback = client, topics, lacking, on_feedback
        self._clock, self._stamp_clock = clock, stamp_clock
        self._tracker = TrackedGoal(uuid4().hex)
        self._answered = asyncio.Event()
        self._result: R | None = None

    async def run(self, goal: Message, answer_timeout: float = ANSWER_TIMEOUT) -> tuple[GoalStatus, R | None]:
        """Send a goal; return its final status, and its result if one has come. A cancelled coroutine cancels it.

        Raises
        ------
        Unavailable
            The clone of the robot has no such node, or it does not know the goal any more.
        PPaaSError
            The client has lost its connection for good.
        """
        client, topics = self._client, self._topics
        await client.subscribe(topics.result.name, topics.result.type, self._on_result)
        await client.subscribe(topics.status.name, GoalStatusArray, self._on_status, queue_size=1)
        await client.subscribe(topics.feedback.name, topics.feedback.type, self._take_feedback, queue_size=10)
        goal_id = GoalID(Time.of(self._stamp_clock()), self._tracker.goal)
        make: Callable[..., Message] = topics.goal.type
        await client.publish(topics.goal.name, make(goal=goal, goal_id=goal_id))
        try:
            await self._first(self._answered.wait(), answer_timeout)
            return await self._outcome()
        except asyncio.CancelledError:
            await self._cancel()
            raise

    async def _outcome(self) -> tuple[GoalStatus, R | None]:
        await self._first(self._tracker.result, None)
        status = self._tracker.result.result()
        if status.status == Status.LOST:
            await self._publish_cancel()
            raise Unavailable("the clone of the robot does not know the goal any more; send it again")
        return status, self._result

    async def _first(self, awaited: Any, timeout: float | None) -> None:
        """Wait for something, and raise if the client fails meanwhile or the time is up."""
        waiting, failed = asyncio.ensure_future(awaited), asyncio.ensure_future(self._client.closed())
        try:
            done, _ = await asyncio.wait({waiting, failed}, timeout=timeout, return_when=asyncio.FIRST_COMPLETED)
            if failed in done and waiting not in done:
                failed.result()
            if not done:
                await self._publish_cancel()  # a node that answers late must not drive the robot
                raise Unavailable(f"no answer within {timeout:g} s: {self._lacking}")
        finally:
            failed.cancel()
            if waiting is not self._tracker.result:
                waiting.cancel()

    async def _cancel(self) -> None:
        await self._publish_cancel()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(asyncio.shield(self._tracker.result), CANCEL_TIMEOUT)

    async def _publish_cancel(self) -> None:
        await self._client.publish(self._topics.cancel.name, GoalID(id=self._tracker.goal))

    # -- messages ------------------------------------------------------------------------------------------------------

    def _on_result(self, message: Any) -> None:
        if message.status.goal_id.id == self._tracker.goal and not self._tracker.result.done():
            self._result = message.result
            self._tracker.result.set_result(message.status)
            self._answered.set()

    def _on_status(self, message: GoalStatusArray) -> None:
        self._tracker.on_status(message, self._clock())
        if self._tracker.result.done() or any(each.goal_id.id == self._tracker.goal for each in message.status_list):
            self._answered.set()

    def _take_feedback(self, message: Any) -> None:
        if message.status.goal_id.id == self._tracker.goal:
            self._answered.set()
            if self._on_feedback is not None:
                self._on_feedback(message.feedback)
