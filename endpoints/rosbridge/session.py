"""What a client of a robot says and is told, whatever socket carries it.

Each frame of the client becomes something done at the robot's place. What is wrong with a frame is told to that client
alone, and only if it asked for ``status`` (by ``set_level`` or ``&status=1``).
"""

import asyncio
import logging
from collections.abc import Callable
from typing import Any

from endpoints.rosbridge.calls import ClientCalls
from endpoints.rosbridge.goals import ClientGoals
from endpoints.rosbridge.outbox import Outbox
from endpoints.rosbridge.roles import Role, check_may_publish
from engine.service.links.place_link import PlaceLink
from ppaas.clock import monotonic
from ppaas.errors import MalformedMessage, NotFound, PPaaSError, rebuild
from ppaas.nodes.base import DEFAULT_DEPTH
from ppaas.nodes.topics import policy_of
from ppaas.wire import operations
from ppaas.wire.names import normalise, ros1_type
from ppaas.wire.rosbridge import RosbridgeSession

logger = logging.getLogger(__name__)

MAX_LOGGED = 64
"""Kinds of faults of one client that are told in the log; clients may think out topics without end."""


PATH_SERVICES = frozenset({"move_base/compute_path", "move_base/make_plan"})
"""Services of the clone that plan a path for whoever calls them."""


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
    count_plan : callable
        Told of each path that the client asks for; raises where it may ask for no more.

    Attributes
    ----------
    outbox : Outbox
        Frames for the client.
    over : Future
        Done once the client must go; its result is the reason.
    """

    def __init__(
        self,
        place: PlaceLink,
        role: Role,
        wire: RosbridgeSession,
        name: str,
        count_plan: Callable[[], None] = lambda: None,
    ) -> None:
        self._place = place
        self._count_plan = count_plan
        self._role = role
        self._wire = wire
        self.name = name
        self.outbox = Outbox()
        self.over: asyncio.Future[PPaaSError] = asyncio.get_running_loop().create_future()
        self._logged: set[tuple[str, str]] = set()
        self._late: asyncio.TimerHandle | None = None
        self._client = place.join(self)
        self._goals = ClientGoals(place, self._client, wire, self.outbox, self._answer)
        self._calls = ClientCalls(place, self._client, wire, self._answer, self._answer_first)
        self._takers: dict[type[operations.Operation], Callable[[Any], None]] = {
            operations.Publish: self._publish,
            operations.Advertise: self._advertise,
            operations.Unadvertise: self._unadvertise,
            operations.Subscribe: self._subscribe,
            operations.Unsubscribe: self._unsubscribe,
            operations.CallService: self._calls.start,
            operations.AdvertiseService: self._calls.advertise,
            operations.UnadvertiseService: self._calls.unadvertise,
            operations.ServiceResponse: self._calls.respond,
            operations.SendActionGoal: self._goals.start,
            operations.CancelActionGoal: self._goals.cancel,
            operations.SetLevel: lambda _: None,  # the wire has noted it
        }

    def end(self) -> None:
        """Leave the place; what was asked is no longer wanted."""
        self._calls.end()
        self._place.leave(self._client)
        if self._late is not None:
            self._late.cancel()

    # -- from the client -----------------------------------------------------------------------------------------------

    def take(self, frame: str | None) -> None:
        """Do what a frame of the client says, None being one of bytes; tell the client what is wrong with it."""
        operation: operations.ClientOperation | None = None
        try:
            if frame is None:
                raise MalformedMessage("binary frames are not understood: send JSON as text")
            operation = self._wire.receive(frame)
            self._takers[type(operation)](operation)
        except PPaaSError as error:
            self._tell(error, operation_id=getattr(operation, "id", None))

    def _answer_first(self, service: str) -> bytes | None:
        if service in PATH_SERVICES:
            self._count_plan()
        return self._goals.cancel_all(service)

    def _publish(self, operation: operations.Publish) -> None:
        topic = normalise(operation.topic)
        check_may_publish(self._role, topic)
        must_arrive = not policy_of(topic).stream
        self._place.publish(topic, bytes(operation.msg), self._client, must_arrive=must_arrive, latch=operation.latch)

    def _advertise(self, operation: operations.Advertise) -> None:
        topic = normalise(operation.topic)
        check_may_publish(self._role, topic)
        self._place.advertise(topic, ros1_type(operation.type), self._client, operation.id, latch=operation.latch)

    def _unadvertise(self, operation: operations.Unadvertise) -> None:
        self._place.unadvertise(normalise(operation.topic), self._client, operation.id)

    def _subscribe(self, operation: operations.Subscribe) -> None:
        topic = normalise(operation.topic)
        try:
            kind = ros1_type(operation.type) if operation.type else None
            self._place.subscribe(topic, self._client, kind)
        except PPaaSError:
            self._wire.forget(operation)
            self._hear_no_more(topic)
            raise
        if self._place.topic_type(topic) is None:
            text = f"there is no topic {topic!r} yet; it is heard as soon as somebody advertises it"
            self._report(rebuild(NotFound.slug, text), "warning", operation.id)

    def _unsubscribe(self, operation: operations.Unsubscribe) -> None:
        self._hear_no_more(normalise(operation.topic))

    def _hear_no_more(self, topic: str) -> None:
        if not self._wire.hears(topic) and not self._goals.hears(topic):
            self._place.unsubscribe(topic, self._client)

    # -- to the client -------------------------------------------------------------------------------------------------

    def _answer(self, frame: bytes) -> None:
        try:
            self.outbox.put_answer(frame)
        except PPaaSError as error:  # an answer is not dropped; rather the client is
            self.closed(error)

    def _tell(self, error: PPaaSError, about: str = "", operation_id: str | None = None) -> None:
        first = (error.slug, about) not in self._logged and len(self._logged) < MAX_LOGGED
        if first:
            self._logged.add((error.slug, about))
        logger.log(logging.WARNING if first else logging.DEBUG, "%s: %s: %s", self.name, error.slug, error)
        self._report(error, "error", operation_id)

    def _report(self, error: PPaaSError, level: operations.Level, operation_id: str | None) -> None:
        status = self._wire.status(error, operation_id, level)
        if status is not None:
            self.outbox.put("", status, DEFAULT_DEPTH)

    def inform(self, slug: str, text: str) -> None:
        """Tell the client of something that is no fault, if it wants to hear of such."""
        self._report(rebuild(slug, text), "info", None)

    def _put(self, topic: str, frame: bytes) -> None:
        self.outbox.put(topic, frame, self._wire.queue_length(topic, policy_of(topic).depth))

    # -- from the place ------------------------------------------------------------------------------------------------

    def published(self, topic: str, payload: bytes) -> None:
        """Take a message of a topic that the client hears."""
        for frame in self._wire.publish(topic, payload, monotonic()):
            self._put(topic, frame)
        self._send_late_in_time()
        if self._goals.hears(topic):
            try:
                self._goals.published(topic, payload)
            except PPaaSError as error:
                self._tell(error, topic)

    def _send_late_in_time(self) -> None:
        """Set the alarm for the messages that came too soon after others."""
        due = self._wire.next_due()
        if due is None:
            return
        loop = asyncio.get_running_loop()
        at = loop.time() + max(due - monotonic(), 0.0)
        if self._late is not None:
            if self._late.when() <= at:
                return
            self._late.cancel()
        self._late = loop.call_at(at, self._send_late)

    def _send_late(self) -> None:
        self._late = None
        for topic, frame in self._wire.due(monotonic()):
            self._put(topic, frame)
        self._send_late_in_time()

    def requested(self, call: int, service: str, payload: bytes) -> None:
        """Take a call of a service that the client offers.

        Raises
        ------
        Unavailable
            The client is too slow to be asked.
        """
        self.outbox.put_answer(self._calls.request(call, service, payload))

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        """Learn that the clone did not take a message of this client."""
        self._goals.refused(sequence, error)
        self._tell(error, topic)

    def closed(self, reason: PPaaSError) -> None:
        """Learn that the place is no more, or no more for this client."""
        if not self.over.done():
            self.over.set_result(reason)
