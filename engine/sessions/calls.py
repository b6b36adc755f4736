"""Service calls of one client, and calls of the services that it offers."""

import itertools
from collections.abc import Callable

import msgspec

from engine.links.open_calls import Outcome
from engine.sessions.namespaces import namespace_hint
from engine.sessions.outbox import Sent
from engine.sessions.place.client_services import Provider
from engine.sessions.place.place import Place
from engine.sessions.rosapi import introspect
from engine.sessions.unsettled import Posting
from ppaas.errors import Conflict, NotFound, PPaaSError, QuotaExceeded, UnknownType, rebuild
from ppaas.messages import service_type
from ppaas.messages.base.message import Message
from ppaas.messages.base.spelling import to_ros2
from ppaas.wire import rosapi
from ppaas.wire.arguments import as_object
from ppaas.wire.fragments import size_of
from ppaas.wire.names import is_ros2_type, ros1_type
from ppaas.wire.operations import (
    AdvertiseService,
    CallService,
    RefusedOperation,
    ServiceResponse,
    UnadvertiseService,
)
from ppaas.wire.refusals import error_of_text
from ppaas.wire.rosbridge import RosbridgeSession

CALL_TIMEOUT = 60.0
"""Upper limit of the timeout of a call [s]."""

MAX_CALLS = 32
"""Largest number of pending calls of one client."""

_PARAMETER_NAMES = "rosapi/get_param_names"

Shortcut = Callable[[str, bytes], bytes | None]
"""Called with the name of a service and the arguments; returns the response at once, or None if it does not handle this
service."""


class ClientCalls:
    """Pending calls of one client, and calls of the services that it offers.

    Parameters
    ----------
    place : Place
        Place of the robot.
    client : int
        Number of the client at the place.
    wire : RosbridgeSession
        Encodes the frames.
    send : callable
        Called with a frame that must not be dropped, the size of its fragments [characters], and a function to call
        once it is sent.
    shortcut : callable
        Called before a call is sent to the place.
    posting : Posting
        Knows the origin of the frame that is executed.
    """

    def __init__(
        self,
        place: Place,
        client: int,
        wire: RosbridgeSession,
        send: Callable[[bytes, int, Sent | None], None],
        shortcut: Shortcut,
        *,
        posting: Posting,
    ) -> None:
        self._posting = posting
        self._place = place
        self._client = client
        self._wire = wire
        self._send = send
        self._shortcut = shortcut
        self._numbers = itertools.count()
        self._calls: dict[int, Callable[[], object]] = {}
        self._spellings: dict[str, str] = {}

    def end(self) -> None:
        """Cancel the pending calls."""
        for cancel in self._calls.values():
            cancel()
        self._calls.clear()

    # -- calls by the client -------------------------------------------------------------------------------------------

    def start(self, operation: CallService) -> None:
        """Start a call; it is always answered by a frame, also if it fails."""
        try:
            self._posting.check_new()
            if len(self._calls) >= MAX_CALLS:
                raise QuotaExceeded(f"a client may have at most {MAX_CALLS} pending calls: wait for a response")
            service, arguments = self._wire.names.callee(operation.service), bytes(operation.args)
            values = self._shortcut(service, arguments) or introspect(
                self._place, service, arguments, self._wire.names, ros2=is_ros2_type(operation.type)
            )
            if values is None:
                self._begin(operation, service)
            else:
                self._answer(operation, values)
        except PPaaSError as error:
            self._answer(operation, error)

    def refuse(self, refused: RefusedOperation) -> None:
        """Answer a call whose frame could not be read."""
        self._answer(CallService(refused.name, refused.id), refused.error)

    def _begin(self, operation: CallService, service: str) -> None:
        known = self._place.service_type(service)
        if known is None and (hint := namespace_hint(service, {**self._place.services, **rosapi.SERVICES})):
            raise rebuild(NotFound.slug, f"unknown service {service!r}{hint}")
        kind = _request_type(known or operation.type)
        requested = operation.timeout or 0.0
        timeout = min(requested, CALL_TIMEOUT) if requested > 0.0 else CALL_TIMEOUT
        number = next(self._numbers)
        of_client = service not in self._place.services
        ros2 = of_client and not operation.type and self._place.client_services.answers_in_ros2(service)

        def done(outcome: Outcome) -> None:
            self._calls.pop(number, None)
            outcome = to_ros2(outcome) if ros2 and isinstance(outcome, bytes) else outcome
            self._answer(operation, _spelled(operation, service, outcome), settle)

        arguments = as_object(bytes(operation.args), kind)
        if service in rosapi.PARAMETER_SERVICES:
            arguments = rosapi.without_namespace(arguments, self._wire.names)
        settle = self._posting.unsettled.until_released()
        try:
            self._calls[number] = self._place.begin_call(service, arguments, timeout, done)
        except PPaaSError:
            settle()
            raise

    def _answer(self, operation: CallService, outcome: Outcome, sent: Sent | None = None) -> None:
        try:
            if isinstance(outcome, PPaaSError):
                raise outcome
            frame = self._wire.answer(operation, outcome)
        except PPaaSError as error:
            frame = self._wire.refuse_call(operation, error)
        self._send(frame, size_of(operation), sent)

    # -- calls to the client ------------------------------------------------------------------------------------------

    def advertise(self, operation: AdvertiseService, provider: Provider) -> None:
        """Register a service that the client offers; ``provider`` gets the calls.

        Raises
        ------
        PPaaSError
            The name or type is invalid, the clone has this service, or the client offers too many.
        """
        service = self._wire.names.resolve(operation.service)
        if service in rosapi.SERVICES:
            raise Conflict(f"service {service!r} belongs to the cloud: choose another name")
        kind, ros2 = ros1_type(operation.type), is_ros2_type(operation.type)
        self._place.advertise_service(service, kind, self._client, provider, ros2=ros2)
        self._spellings[service] = operation.service

    def unadvertise(self, operation: UnadvertiseService) -> None:
        """Remove a service that the client offers.

        Raises
        ------
        NotFound
            The client does not offer it.
        """
        service = self._wire.names.resolve(operation.service)
        self._place.client_services.unadvertise(service, self._client)
        self._spellings.pop(service, None)

    def request(self, call: int, service: str, arguments: bytes) -> bytes:
        """Return the frame of a call to the client."""
        return self._wire.request(self._spellings[service], call, arguments)

    def respond(self, operation: ServiceResponse) -> None:
        """Handle the client's response to a call.

        Raises
        ------
        NotFound
            No call with this id is pending.
        NotPermitted
            The call was made to another client.
        """
        number = "" if operation.id is None else str(operation.id)
        if not (number.isascii() and number.isdigit() and len(number) < 16):
            raise NotFound("open call", number[:64])
        values = bytes(operation.values)
        answer = values if operation.result else error_of_text(_reason(values, operation.service))
        self._place.client_services.answer(int(number), self._client, answer)


def _spelled(operation: CallService, service: str, outcome: Outcome) -> Outcome:
    if service != _PARAMETER_NAMES or not is_ros2_type(operation.type) or isinstance(outcome, PPaaSError):
        return outcome
    try:
        return rosapi.parameter_names_in_ros2(outcome)
    except PPaaSError as error:
        return error


def _request_type(name: str | None) -> type[Message] | None:
    try:
        return service_type(name).request if name is not None else None
    except UnknownType:
        return None  # without the type, a list of arguments cannot be converted


def _reason(values: bytes, service: str) -> str:
    reason = msgspec.json.decode(values)
    return reason if isinstance(reason, str) and reason else f"service {service!r}: the client reported a failure"
