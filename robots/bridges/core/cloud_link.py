"""Connection of a bridge to the cloud: messages as JSON, whose types need not be known here.

The link is a `robots.client.RobotClient`, with actions in place of typed messages. A lost connection is
reestablished, and its session resumed; subscriptions and advertisements are renewed if the cloud begins another one.
"""

import asyncio
import itertools
import logging
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from types import TracebackType
from typing import Any, Self
from uuid import uuid4

import msgspec

from ppaas.errors import Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.wire.operations import (
    Advertise,
    CallService,
    CancelActionGoal,
    Publish,
    SendActionGoal,
    Subscribe,
    Unsubscribe,
)
from ppaas.wire.refusals import error_of_text
from robots.client.connection import Address, ConnectionOptions, Role, backoff
from robots.client.connection_keeper import ConnectionKeeper
from robots.client.send_queue import SUBSCRIPTION, SendQueue

logger = logging.getLogger(__name__)

CAPACITY = 256
"""Largest number of queued frames."""

CONNECT_TIMEOUT = 30.0
"""Time limit of the first connection [s]."""

LOST = "the connection to the cloud was lost, and with it the outcome"
"""Reason of calls and goals that ended with the session."""

UNKNOWN = 0
"""Status of a goal that was refused, or whose outcome is unknown."""

Json = Callable[[bytes], None]
"""Called with a message as JSON."""


class _Frame(msgspec.Struct):
    op: str
    id: str | int | None = None
    topic: str = ""
    msg: msgspec.Raw = msgspec.Raw(b"null")
    values: msgspec.Raw = msgspec.Raw(b"null")
    result: bool = False
    status: int = UNKNOWN


@dataclass(frozen=True, slots=True)
class CloudGoalEnd:
    """End of a goal: the status as in ROS 2 (4, 5, 6, or 0), and the result as JSON or the reason as text."""

    status: int
    result: bytes
    reason: str


class CloudGoal:
    """Goal that was sent to the cloud.

    Attributes
    ----------
    end : Future of CloudGoalEnd
        Set when the goal has ended.
    """

    def __init__(self, action: str, number: str, feedback: Json) -> None:
        self.action, self.number, self.feedback = action, number, feedback
        self.end: asyncio.Future[CloudGoalEnd] = asyncio.get_running_loop().create_future()


class CloudLink:
    """Client of the cloud for one robot, whose messages are JSON.

    Parameters
    ----------
    url, robot, token : str
        URL of the cloud, id of the robot, and token of its owner.
    renewed : callable
        Called when a session begins, the first included: the clone may be another one.
    operator : bool
        Whether the bridge stands beside the robot, which is connected by itself, and does not keep its clone.
    """

    def __init__(
        self,
        url: str,
        *,
        robot: str,
        token: str,
        renewed: Callable[[], None] = lambda: None,
        operator: bool = False,
    ) -> None:
        self._queue = SendQueue(CAPACITY)
        role: Role = "operator" if operator else "robot"
        session = f"bridge-{uuid4().hex[:16]}"
        self._keeper = ConnectionKeeper(
            Address(url, robot=robot, token=token, role=role, session=session, hold=not operator),
            ConnectionOptions(),
            self._queue,
            backoff,
            greeting=self._greeting,
            received=self._receive,
            lost=self._session_lost,
        )
        self._renewed = renewed
        self._subscriptions: dict[str, tuple[Subscribe, Json]] = {}
        self._offers: dict[str, Advertise] = {}
        self._calls: dict[str, asyncio.Future[bytes]] = {}
        self._goals: dict[str, CloudGoal] = {}
        self._numbers = itertools.count(1)
        self._decoder = msgspec.json.Decoder(_Frame)
        self._runner: asyncio.Task[None] | None = None
        self._reported: set[str] = set()
        self._faults = ListenerFaults(logger)

    async def __aenter__(self) -> Self:
        """Connect.

        Raises
        ------
        PPaaSError
            The reason of the cloud's refusal, or ``Unavailable`` if it was not reached in time.
        """
        self._runner = asyncio.create_task(self._keeper.run())
        try:
            await self._keeper.wait_connected(self._runner, CONNECT_TIMEOUT, self._check)
        except BaseException:
            await self._stop()
            raise
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self._stop()

    def _check(self) -> None:
        if self._runner is not None and self._runner.done():
            self._runner.result()

    async def _stop(self) -> None:
        if self._runner is not None:
            self._runner.cancel()
            await asyncio.gather(self._runner, return_exceptions=True)
        self._queue.close(Unavailable("the bridge is closed"))
        self._session_lost()

    @property
    def connected(self) -> bool:
        """Whether the link is connected now."""
        return self._keeper.connected.is_set()

    async def closed(self) -> None:
        """Wait until the cloud refuses the bridge for good, and raise the reason."""
        if self._runner is not None:
            await asyncio.shield(self._runner)

    # -- topics --------------------------------------------------------------------------------------------------------

    def publish_newest(self, topic: str, message: bytes, key: str = "") -> None:
        """Publish a message in place of a queued one of the same key (the topic): for streams on a slow link."""
        self._queue.put_newest(key or topic, _text(Publish(topic, msgspec.Raw(message))))

    def publish_together(self, key: str, messages: Iterable[tuple[str, bytes]]) -> None:
        """Publish messages of several topics in one frame, in place of a queued frame of the same key."""
        frame = "".join(_text(Publish(topic, msgspec.Raw(message))) for topic, message in messages)
        self._queue.put_newest(key, frame)

    async def publish(self, topic: str, message: bytes) -> None:
        """Publish a message that must not be lost; waits while the queue is full."""
        await self._queue.put(_text(Publish(topic, msgspec.Raw(message))))

    async def drained(self) -> None:
        """Wait until all messages are sent."""
        await self._queue.drained()

    async def advertise(self, topic: str, type_name: str) -> None:
        """Make a topic known that the clone does not have."""
        offer = self._offers[topic] = Advertise(topic, type_name)
        await self._queue.put(_text(offer), SUBSCRIPTION)

    async def subscribe(
        self, topic: str, type_name: str, received: Json, *, queue_length: int = 0, period: float = 0.0
    ) -> None:
        """Subscribe to a topic, with at most one message in each period [s]; one callback a topic."""
        wanted = Subscribe(
            topic,
            id=f"subscribe:{topic}",
            type=type_name,
            queue_length=queue_length,
            throttle_rate=round(1000 * period),
        )
        self._subscriptions[topic] = wanted, received
        await self._queue.put(_text(wanted), SUBSCRIPTION)

    async def unsubscribe(self, topic: str) -> None:
        """End the subscription to a topic."""
        if self._subscriptions.pop(topic, None) is not None:
            await self._queue.put(_text(Unsubscribe(topic)), SUBSCRIPTION)

    # -- services and actions ------------------------------------------------------------------------------------------

    async def call(self, service: str, type_name: str, request: bytes, timeout: float = 10.0) -> bytes:
        """Call a service of the clone; return the response as JSON.

        Raises
        ------
        Unavailable
            There was no response within ``timeout`` seconds, or the session was lost.
        PPaaSError
            The error that the service returned.
        """
        number = f"call:{next(self._numbers)}"
        future: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()
        self._calls[number] = future
        try:
            async with asyncio.timeout(timeout):
                await self._queue.put(
                    _text(CallService(service, id=number, args=msgspec.Raw(request), type=type_name)), number
                )
                return await future
        except TimeoutError as error:
            raise Unavailable(f"service {service!r} did not answer within {timeout:g} s") from error
        finally:
            del self._calls[number]
            self._queue.discard(number)  # nobody waits for the response any more

    async def send_goal(self, action: str, type_name: str, goal: bytes, feedback: Json) -> CloudGoal:
        """Send a goal to an action of the clone; ``feedback`` is called with each feedback."""
        number = f"goal:{next(self._numbers)}"
        sent = self._goals[number] = CloudGoal(action, number, feedback)
        frame = SendActionGoal(action, type_name, id=number, args=msgspec.Raw(goal), feedback=True)
        await self._queue.put(_text(frame), number)
        return sent

    async def cancel_goal(self, goal: CloudGoal) -> None:
        """Cancel a goal; it ends with a result as any other."""
        await self._queue.put(_text(CancelActionGoal(goal.action, id=goal.number)), goal.number)

    # -- frames --------------------------------------------------------------------------------------------------------

    def _greeting(self) -> list[str]:
        asyncio.get_running_loop().call_soon(self._renewed)  # later: what it sends belongs behind the greeting
        subscriptions = [wanted for wanted, _ in self._subscriptions.values()]
        return [_text(operation) for operation in (*self._offers.values(), *subscriptions)]

    def _session_lost(self) -> None:
        lost = Unavailable(LOST)
        for future in self._calls.values():
            if not future.done():
                future.set_exception(lost)
        for goal in list(self._goals.values()):
            self._end(goal, CloudGoalEnd(UNKNOWN, b"{}", str(lost)))

    def _receive(self, text: str | bytes) -> None:
        try:
            frame = self._decoder.decode(text)
        except (msgspec.DecodeError, UnicodeDecodeError) as error:
            logger.warning("ignored an invalid frame of the cloud: %s", error)
            return
        if frame.op == "publish":
            wanted = self._subscriptions.get(frame.topic)
            if wanted is not None:
                self._deliver(frame.topic, wanted[1], frame.msg)
        elif frame.op == "service_response":
            self._respond(frame)
        elif frame.op in ("action_feedback", "action_result"):
            self._goal_frame(frame)
        elif frame.op == "status":
            self._report(str(msgspec.json.decode(frame.msg)))

    def _deliver(self, name: str, received: Json, message: msgspec.Raw) -> None:
        error = self._faults.deliver(f"the part of the bridge that takes {name!r}", received, bytes(message))
        if error is not None:
            self._report(str(error))

    def _respond(self, frame: _Frame) -> None:
        future = self._calls.get(str(frame.id))
        if future is None or future.done():
            return
        if frame.result:
            future.set_result(bytes(frame.values))
        else:
            future.set_exception(error_of_text(_reason(frame.values)))

    def _goal_frame(self, frame: _Frame) -> None:
        goal = self._goals.get(str(frame.id))
        if goal is None:
            return
        if frame.op == "action_feedback":
            self._deliver(goal.action, goal.feedback, frame.values)
            return
        refused = not frame.result
        result = b"{}" if refused else bytes(frame.values)
        self._end(goal, CloudGoalEnd(frame.status, result, _reason(frame.values) if refused else ""))

    def _end(self, goal: CloudGoal, end: CloudGoalEnd) -> None:
        self._goals.pop(goal.number, None)
        if not goal.end.done():
            goal.end.set_result(end)

    def _report(self, text: str) -> None:
        """Log an error; the same one is logged once, for a robot may cause it with each of its messages."""
        if text not in self._reported and len(self._reported) < CAPACITY:
            self._reported.add(text)
            logger.warning("the cloud reported: %s", text)


def _text(operation: msgspec.Struct) -> str:
    return msgspec.json.encode(operation).decode()


def _reason(values: msgspec.Raw) -> str:
    reason: Any = msgspec.json.decode(values)
    return reason if isinstance(reason, str) else "it failed without a reason"
