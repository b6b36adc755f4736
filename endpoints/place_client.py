"""Client of a place within this process: operations in, messages and answers out, as rosbridge has them.

Its session is in the container of the place, as for any client. Errors that the endpoint can see are raised at
once; what the session refuses is reported later.
"""

import itertools
import logging
from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import TypeAlias

import msgspec

from endpoints.rosbridge import Attachment
from engine.links.open_calls import Done, OpenCalls, Outcome, answer_of
from engine.links.place_link import PlaceLink
from engine.sessions.calls import CALL_TIMEOUT
from ppaas.errors import Conflict, MalformedMessage, PPaaSError, QuotaExceeded, Unavailable
from ppaas.listener_faults import ListenerFaults
from ppaas.wire import operations
from ppaas.wire.refusals import error_of_text

logger = logging.getLogger(__name__)

Hear: TypeAlias = Callable[[bytes], None]
"""Called with a message as JSON."""

Serve: TypeAlias = Callable[[bytes, Done], None]
"""Called with a request as JSON; answers by its second parameter."""

MAX_WAITING = 32
"""Largest number of calls without an answer; the session has the same limit."""

PATIENCE = CALL_TIMEOUT + 5.0
"""Time after which a call fails that the session has not answered [s], for example because no container has it."""

_CALL = "call:"
"""Beginning of the ids of calls."""


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
_json = msgspec.json.Decoder(msgspec.Raw)


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
        self._calls = OpenCalls()
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
        self._calls.fail(Unavailable("the container was closed before it answered"))

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
        """Publish a message in JSON; raises ``NotPermitted`` or ``MalformedMessage``."""
        self.attachment.session.access.check_publish(topic)
        self._execute(operations.Publish(topic, _checked(topic, payload), self._next()))

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

    def call(self, service: str, payload: bytes, done: Done) -> Callable[[], object]:
        """Call a service of the place; ``done`` is called once with the outcome.

        Returns
        -------
        callable
            Gives the call up: ``done`` is not called any more.

        Raises
        ------
        Unavailable
            The client is detached.
        QuotaExceeded
            Too many calls have no answer yet.
        MalformedMessage
            The request is not JSON.
        """
        if self._detached:
            raise Unavailable("the container was closed")
        if len(self._calls) >= MAX_WAITING:
            raise QuotaExceeded(f"a container may have at most {MAX_WAITING} calls without an answer: wait for one")
        request = _checked(service, payload)
        number = self._calls.open(service, PATIENCE, done)
        self._execute(operations.CallService(service, f"{_CALL}{number}", request))
        return partial(self._calls.give_up, number)

    async def ask(self, service: str, payload: bytes) -> bytes:
        """Call a service like `call`, wait, and return the response as JSON; raises the error of the call."""
        return await answer_of(partial(self.call, service, payload))

    def offer(self, service: str, kind: str, serve: Serve) -> None:
        """Offer a service; raises ``Conflict`` if the clone has it."""
        if service in self.place.services:
            raise Conflict(f"service {service!r} is provided by the clone: choose another name")
        self._execute(operations.AdvertiseService(service, kind))
        self._served[service] = serve

    def withdraw(self, service: str) -> None:
        """Withdraw a service."""
        if self._served.pop(service, None) is not None:
            self._execute(operations.UnadvertiseService(service))

    # -- frames --------------------------------------------------------------------------------------------------------

    def _next(self) -> str:
        return next(self._ids)

    def _execute(self, operation: operations.Operation) -> None:
        """Send an operation to the session, unless the client is detached."""
        if not self._detached:
            self.attachment.session.take(_encoder.encode(operation))

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
            error = self._faults.deliver(f"a listener to topic {topic!r}", hear, payload)
            if error is not None:  # of the other end: this session must go on
                self._report(error)

    def _answered(self, frame: _Frame) -> None:
        values = bytes(frame.values)
        self._end(frame.id, values if frame.result else error_of_text(_text(frame.values), Unavailable))

    def _end(self, identity: str | int | None, outcome: Outcome) -> bool:
        """End a call; return whether the id names a call."""
        name, mark, number = str(identity).partition(_CALL)
        if name or not mark or not number.isdecimal():
            return False
        self._calls.end(int(number), outcome)
        return True

    def _requested(self, frame: _Frame) -> None:
        def done(outcome: Outcome) -> None:
            failed = isinstance(outcome, PPaaSError)
            try:
                text = _encoder.encode(outcome.public) if isinstance(outcome, PPaaSError) else outcome
                values = _checked(frame.service, text)
                self._execute(operations.ServiceResponse(frame.service, not failed, values, frame.id))
            except PPaaSError as error:
                self._report(error)

        serve = self._served.get(frame.service)
        if serve is None:
            done(Unavailable(f"no interface serves {frame.service!r} now"))
            return
        error = self._faults.deliver(f"what serves {frame.service!r}", serve, bytes(frame.args), done)
        if error is not None:
            done(error)

    def _failed(self, frame: _Frame) -> None:
        error = error_of_text(_text(frame.msg))
        if not self._end(frame.id, error):
            self._report(error)


def _text(value: msgspec.Raw) -> str:
    return str(msgspec.json.decode(value))


def _checked(name: str, payload: bytes) -> msgspec.Raw:
    """Return a message or a request to be put into an operation; raises ``MalformedMessage`` unless it is JSON."""
    try:
        payload.decode()
        return _json.decode(payload)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise MalformedMessage(f"what is sent to {name!r} is not JSON: {error}") from error
