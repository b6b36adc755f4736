"""Client of a place within this process: operations in, messages and answers out, as rosbridge has them.

Its session is in the container of the place, as that of any client. Errors that the endpoint can see are raised at
once; what the session refuses is reported later.
"""

import asyncio
import itertools
import logging
from collections import defaultdict
from collections.abc import Callable
from typing import Any, TypeAlias

import msgspec

from endpoints.rosbridge.attachment import Attachment
from engine.service.links.place_link import PlaceLink
from ppaas.errors import Conflict, PPaaSError, QuotaExceeded, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.wire import operations
from ppaas.wire.refusals import error_of_text

logger = logging.getLogger(__name__)

Outcome: TypeAlias = bytes | PPaaSError
"""Response as JSON, or an error."""

Done: TypeAlias = Callable[[Outcome], None]
"""Called once with the outcome of a call."""

Hear: TypeAlias = Callable[[bytes], None]
"""Called with a message as JSON."""

Serve: TypeAlias = Callable[[bytes, Done], None]
"""Called with a request as JSON; answers by its second parameter."""

MAX_WAITING = 32
"""Largest number of calls without an answer; the session has the same limit."""


class _Frame(msgspec.Struct):
    """Frame of rosbridge from the cloud: the fields of all kinds that are used here."""

    op: str
    id: str | int | None = None
    topic: str = ""
    service: str = ""
    msg: msgspec.Raw = msgspec.Raw(b"null")
    args: msgspec.Raw = msgspec.Raw(b"{}")
    values: msgspec.Raw = msgspec.Raw(b"null")
    result: bool = False


_decoder = msgspec.json.Decoder(_Frame)
_encoder = msgspec.json.Encoder()


class PlaceClient:
    """Client of a place.

    Parameters
    ----------
    attachment : Attachment
        Attachment to the session at the place.
    report : callable
        Called with errors that concern no call, such as a message that the clone refuses.
    """

    ready = True
    """The session need not wait: what comes is passed on at once."""

    def __init__(self, attachment: Attachment, report: Callable[[PPaaSError], None]) -> None:
        self.attachment = attachment
        self._report = report
        self._ids = map(str, itertools.count(1))
        self._hearers: defaultdict[str, list[Hear]] = defaultdict(list)
        self._calls: dict[str, Done] = {}
        self._served: dict[str, Serve] = {}
        self._detached = False
        self._faults = ListenerFaults(logger)
        attachment.session.connect(self)

    @property
    def place(self) -> PlaceLink:
        """Place of the robot."""
        return self.attachment.place

    def detach(self) -> None:
        """Take no further frames; calls without an answer fail."""
        self._detached = True
        self.attachment.session.connect(None)
        calls, self._calls = self._calls, {}
        for done in calls.values():
            self._faults.call("a caller", done, Unavailable("the container was closed before it answered"))

    # -- topics --------------------------------------------------------------------------------------------------------

    def advertise(self, topic: str, kind: str) -> str:
        """Advertise a topic and return the id of the advertisement.

        Raises
        ------
        Conflict
            The topic has another type.
        NotPermitted
            The client may not publish it.
        """
        self.attachment.session.access.check_publish(topic)
        self.place.check_topic_type(topic, kind)
        number = self._next()
        self._execute(operations.Advertise(topic, kind, number))
        return number

    def unadvertise(self, topic: str, advertisement: str) -> None:
        """Withdraw an advertisement."""
        self._execute(operations.Unadvertise(topic, advertisement))

    def publish(self, topic: str, payload: bytes) -> None:
        """Publish a message; raises ``NotPermitted`` if it may not be published."""
        self.attachment.session.access.check_publish(topic)
        self._execute(operations.Publish(topic, msgspec.Raw(payload), self._next()))

    def subscribe(self, topic: str, kind: str, hear: Hear) -> None:
        """Pass the messages of a topic to ``hear``; called again, it gets the latched message again.

        Raises
        ------
        Conflict
            The topic has another type.
        NotPermitted
            The client may not subscribe to it.
        """
        self.attachment.session.access.check_subscribe(topic)
        self.place.check_topic_type(topic, kind)
        hearers = self._hearers[topic]
        if hear not in hearers:
            hearers.append(hear)
        self._execute(operations.Subscribe(topic, topic, kind))

    def unsubscribe(self, topic: str, hear: Hear) -> None:
        """End a subscription."""
        hearers = self._hearers[topic]
        hearers.remove(hear)
        if not hearers:
            del self._hearers[topic]
            self._execute(operations.Unsubscribe(topic, topic))

    # -- services ------------------------------------------------------------------------------------------------------

    def call(self, service: str, payload: bytes, done: Done) -> None:
        """Call a service of the place.

        Raises
        ------
        Unavailable
            The client is detached.
        QuotaExceeded
            Too many calls have no answer yet.
        """
        if self._detached:
            raise Unavailable("the container was closed")
        if len(self._calls) >= MAX_WAITING:
            raise QuotaExceeded(f"a container may have at most {MAX_WAITING} calls without an answer: wait for one")
        number = self._next()
        self._calls[number] = done
        self._execute(operations.CallService(service, number, msgspec.Raw(payload)))

    async def ask(self, service: str, payload: bytes) -> bytes:
        """Call a service like `call`, wait, and return the response as JSON; raises the error of the call."""
        answered: asyncio.Future[bytes] = asyncio.get_running_loop().create_future()

        def done(outcome: Outcome) -> None:
            if answered.done():
                return
            if isinstance(outcome, PPaaSError):
                answered.set_exception(outcome)
            else:
                answered.set_result(outcome)

        self.call(service, payload, done)
        return await answered

    def offer(self, service: str, kind: str, serve: Serve) -> None:
        """Offer a service; raises ``Conflict`` if the clone has it."""
        if service in self.place.services:
            raise Conflict(f"service {service!r} is provided by the clone: choose another name")
        self._execute(operations.AdvertiseService(service, kind))
        self._served[service] = serve

    def withdraw(self, service: str) -> None:
        """Offer a service no longer."""
        if self._served.pop(service, None) is not None:
            self._execute(operations.UnadvertiseService(service))

    # -- frames --------------------------------------------------------------------------------------------------------

    def _next(self) -> str:
        return next(self._ids)

    def _execute(self, operation: operations.Operation) -> None:
        """Send an operation to the session, unless the client is detached."""
        if not self._detached:
            self.attachment.session.take(_encoder.encode(operation).decode())

    def send_frame(self, frame: bytes) -> None:
        """Take a frame from the session."""
        received = _decoder.decode(frame)
        match received.op:
            case "publish":
                self._heard(received.topic, bytes(received.msg))
            case "service_response":
                self._answered(received)
            case "call_service":
                self._requested(received)
            case "status":
                self._failed(received)

    def _heard(self, topic: str, payload: bytes) -> None:
        for hear in tuple(self._hearers.get(topic, ())):
            try:
                hear(payload)
            except PPaaSError as error:  # of the other end: this session must go on
                self._report(error)
            except Exception as error:
                self._report(self._faults.note(f"a listener to topic {topic!r}", error))

    def _answered(self, frame: _Frame) -> None:
        done = self._calls.pop(str(frame.id), None)
        if done is None:
            return
        values = bytes(frame.values)
        outcome = values if frame.result else error_of_text(str(msgspec.json.decode(values)), Unavailable)
        self._faults.call("a caller", done, outcome)

    def _requested(self, frame: _Frame) -> None:
        def done(outcome: Outcome) -> None:
            failed = isinstance(outcome, PPaaSError)
            values: Any = outcome.public if isinstance(outcome, PPaaSError) else msgspec.Raw(outcome)
            answer = operations.ServiceResponse(
                frame.service, not failed, msgspec.Raw(_encoder.encode(values)), frame.id
            )
            try:
                self._execute(answer)
            except PPaaSError as error:
                self._report(error)

        serve = self._served.get(frame.service)
        if serve is None:
            done(Unavailable(f"no interface serves {frame.service!r} now"))
            return
        try:
            serve(bytes(frame.args), done)
        except PPaaSError as error:
            done(error)
        except Exception as error:
            done(self._faults.note(f"what serves {frame.service!r}", error))

    def _failed(self, frame: _Frame) -> None:
        self._report(error_of_text(str(msgspec.json.decode(bytes(frame.msg)))))
