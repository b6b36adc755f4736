"""What a client of a robot says and is told, whatever socket carries it.

Each frame of the client becomes something done at the robot's place. What is wrong with a frame is told to that client
alone, and only if it asked for ``status`` (by ``set_level`` or ``&status=1``).
"""

import asyncio
import logging
from typing import assert_never

from endpoints.outbox import DEFAULT_KEEP, KEEP, Outbox
from endpoints.rights import Role, check_may_publish, must_arrive
from engine.place_link import PlaceLink
from ppaas.clock import monotonic
from ppaas.errors import MalformedMessage, PPaaSError, QuotaExceeded
from ppaas.messages import message_type
from ppaas.wire import rosbridge
from ppaas.wire.names import normalise

logger = logging.getLogger(__name__)

CALL_TIMEOUT = 60.0
MAX_CALLS = 32
"""Calls of one client that may be under way at a time."""

MAX_LOGGED = 64
"""Kinds of faults of one client that are told in the log; clients may think out topics without end."""


class ClientSession:
    """One client of one place.

    Parameters
    ----------
    place : PlaceLink
        Of the robot.
    role : {"robot", "operator"}
        What it may publish.
    wire : RosbridgeSession
        What was said so far.
    name : str
        For the log.

    Attributes
    ----------
    outbox : Outbox
        Frames for the client.
    over : Future
        Done once the client must go; its result is the reason.
    """

    def __init__(self, place: PlaceLink, role: Role, wire: rosbridge.RosbridgeSession, name: str) -> None:
        self._place = place
        self._role = role
        self._wire = wire
        self.name = name
        self.outbox = Outbox()
        self.over: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self._calls: set[asyncio.Task[None]] = set()
        self._logged: set[tuple[str, str]] = set()
        self._client = place.join(self)

    async def end(self) -> None:
        """Leave the place; what was asked is no longer wanted."""
        self._place.leave(self._client)
        for call in self._calls:
            call.cancel()
        await asyncio.gather(*self._calls, return_exceptions=True)

    # -- from the client -----------------------------------------------------------------------------------------------

    def take(self, frame: str | None) -> None:
        """Do what a frame of the client says, None being one of bytes; tell the client what is wrong with it."""
        try:
            self._take(frame)
        except PPaaSError as error:
            self._tell(error)

    def _take(self, frame: str | None) -> None:
        if frame is None:
            raise MalformedMessage("binary frames are not understood: send JSON as text")
        operation = self._wire.receive(frame)
        match operation:
            case rosbridge.Publish():
                topic = normalise(operation.topic)
                check_may_publish(self._role, topic)
                self._place.deliver(topic, bytes(operation.msg), self._client, must_arrive=must_arrive(topic))
            case rosbridge.Subscribe():
                self._subscribe(normalise(operation.topic))
            case rosbridge.Unsubscribe():
                topic = normalise(operation.topic)
                if topic not in self._wire.subscribed():
                    self._place.unsubscribe(topic, self._client)
            case rosbridge.Advertise():
                check_may_publish(self._role, normalise(operation.topic))
                message_type(operation.type)
            case rosbridge.Unadvertise() | rosbridge.SetLevel():
                pass
            case rosbridge.CallService():
                self._start_call(operation)
            case _:
                assert_never(operation)

    def _subscribe(self, topic: str) -> None:
        try:
            self._place.subscribe(topic, self._client)
        except PPaaSError:
            self._wire.forget(topic)
            raise

    def _start_call(self, operation: rosbridge.CallService) -> None:
        if len(self._calls) >= MAX_CALLS:
            error = QuotaExceeded(f"a client may have {MAX_CALLS} calls under way")
            self._answer(self._wire.refuse_call(operation, error))
            return
        task = asyncio.create_task(self._call(operation))
        self._calls.add(task)
        task.add_done_callback(self._calls.discard)

    async def _call(self, operation: rosbridge.CallService) -> None:
        try:
            service = normalise(operation.service)
            values = await self._place.call(service, bytes(operation.args), CALL_TIMEOUT)
            frame = self._wire.answer(operation, values)
        except PPaaSError as error:
            frame = self._wire.refuse_call(operation, error)
        self._answer(frame)

    def _answer(self, frame: str) -> None:
        try:
            self.outbox.put_answer(frame)
        except PPaaSError as error:  # an answer is not dropped; rather the client is
            self.closed(error)

    def _tell(self, error: PPaaSError, about: str = "") -> None:
        first = (error.slug, about) not in self._logged and len(self._logged) < MAX_LOGGED
        if first:
            self._logged.add((error.slug, about))
        logger.log(logging.WARNING if first else logging.DEBUG, "%s: %s: %s", self.name, error.slug, error)
        status = self._wire.status(error)
        if status is not None:
            self.outbox.put("", status, DEFAULT_KEEP)

    # -- from the place ------------------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Take a message of a topic that the client subscribed to."""
        keep = self._wire.queue_length(topic, KEEP.get(topic, DEFAULT_KEEP))
        for frame in self._wire.publish(topic, payload, monotonic()):
            self.outbox.put(topic, frame, keep)

    def refused(self, topic: str, error: PPaaSError) -> None:
        """Learn that the clone did not take a message of this client."""
        self._tell(error, topic)

    def closed(self, reason: PPaaSError) -> None:
        """Learn that the place is no more, or no more for this client."""
        if not self.over.done():
            self.over.set_result(reason)
