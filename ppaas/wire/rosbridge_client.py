"""Client side of rosbridge v2: encodes a client's operations, and decodes the server's frames.

The server side is ``ppaas.wire.rosbridge``. A session outlives its connections: it remembers subscriptions and
advertised services, so that they can be sent again on the next connection.
"""

import itertools
from collections.abc import Collection

import msgspec

from ppaas.errors import MalformedMessage, PPaaSError, Unavailable
from ppaas.messages import Message, ServiceType, encode, type_name
from ppaas.wire import operations
from ppaas.wire.names import normalise
from ppaas.wire.operations import (
    AdvertiseService,
    CallService,
    Operation,
    Publish,
    Subscribe,
    UnadvertiseService,
    Unsubscribe,
)
from ppaas.wire.refusals import error_of_text

_encoder = msgspec.json.Encoder()


class ReceivedMessage(Operation, tag="publish"):
    """Message of a subscribed topic; ``msg`` is its JSON."""

    topic: str
    msg: msgspec.Raw


class ServiceResult(Operation, tag="service_response"):
    """Response to a call; if ``result`` is false, ``values`` is the reason as text."""

    service: str
    result: bool
    values: msgspec.Raw = msgspec.Raw(b"{}")
    id: str | None = None


class StatusReport(Operation, tag="status"):
    """Report of an error in an operation of the client."""

    level: str
    msg: str
    id: str | None = None

    def error(self) -> PPaaSError:
        """Return the reported error."""
        return error_of_text(self.msg)


ServerOperation = ReceivedMessage | ServiceResult | StatusReport | CallService

_decoder: msgspec.json.Decoder[ServerOperation] = msgspec.json.Decoder(ServerOperation)


class RosbridgeClientSession:
    """Protocol state of one client over all its connections: subscriptions, advertised services and pending calls."""

    def __init__(self) -> None:
        self._subscriptions: dict[str, Subscribe] = {}
        self._offers: dict[str, AdvertiseService] = {}
        self._calls: dict[str, str] = {}
        self._sequence = itertools.count(1)

    # -- to the server -----------------------------------------------------------------------------------------------

    def subscribe(self, topic: str, kind: type[Message], throttle: float = 0.0, queue_length: int = 0) -> str:
        """Return the frame that subscribes to a topic; subscribing again replaces the options.

        Parameters
        ----------
        topic : str
            Name of the topic, with or without a leading slash.
        kind : type of Message
            Message type of the topic.
        throttle : float
            Least time between two messages [s].
        queue_length : int
            Number of messages that the cloud queues while the link is slow; 0 for the cloud's default.

        Raises
        ------
        MalformedMessage
            ``topic`` is not a ROS graph name.
        """
        wanted = Subscribe(
            topic,
            id=f"subscribe:{normalise(topic)}",
            type=type_name(kind),
            throttle_rate=round(throttle * 1000.0),
            queue_length=queue_length,
        )
        self._subscriptions[normalise(topic)] = wanted
        return _text(wanted)

    def unsubscribe(self, topic: str) -> str:
        """Return the frame that ends a subscription."""
        self._subscriptions.pop(normalise(topic), None)
        return _text(Unsubscribe(topic))

    def publish(self, topic: str, message: Message) -> str:
        """Return the frame that publishes a message.

        Raises
        ------
        MalformedMessage
            ``topic`` is not a ROS graph name.
        """
        normalise(topic)
        return _text(Publish(topic, msgspec.Raw(encode(message))))

    def call(self, service: str, request: Message) -> tuple[str, str]:
        """Return the id and the frame of a new call.

        Raises
        ------
        MalformedMessage
            ``service`` is not a ROS graph name.
        """
        normalise(service)
        call_id = f"call:{next(self._sequence)}"
        self._calls[call_id] = service
        return call_id, _text(CallService(service, id=call_id, args=msgspec.Raw(encode(request))))

    def give_up(self, call_id: str) -> None:
        """Stop waiting for the response to a call."""
        self._calls.pop(call_id, None)

    def advertise_service(self, service: str, kind: ServiceType) -> str:
        """Return the frame that advertises a service.

        Raises
        ------
        MalformedMessage
            ``service`` is not a ROS graph name.
        """
        offer = self._offers[normalise(service)] = AdvertiseService(service, kind.name)
        return _text(offer)

    def unadvertise_service(self, service: str) -> str:
        """Return the frame that ends the advertisement of a service."""
        self._offers.pop(normalise(service), None)
        return _text(UnadvertiseService(service))

    def respond(self, call: CallService, response: Message) -> str:
        """Return the frame with the response to a call of an advertised service."""
        values = msgspec.Raw(encode(response))
        return _text(operations.ServiceResponse(call.service, result=True, values=values, id=call.id))

    def refuse(self, call: CallService, error: PPaaSError) -> str:
        """Return the frame that reports the failure of a call of an advertised service."""
        reason = msgspec.Raw(_encoder.encode(f"{error.slug}: {error}"))
        return _text(operations.ServiceResponse(call.service, result=False, values=reason, id=call.id))

    def reconnected(self) -> list[str]:
        """Return the first frames of a new connection: all subscriptions and advertisements."""
        return [_text(operation) for operation in (*self._subscriptions.values(), *self._offers.values())]

    def disconnected(self, unsent: Collection[str] = ()) -> dict[str, Unavailable]:
        """Return the calls that were lost with the connection, each with its error, and stop waiting for them.

        Parameters
        ----------
        unsent : collection of str
            Ids of calls that were not sent yet; they stay pending.
        """
        lost = {
            call_id: Unavailable(f"the connection was lost during the call of {service!r}; call it again")
            for call_id, service in self._calls.items()
            if call_id not in unsent
        }
        self._calls = {call_id: service for call_id, service in self._calls.items() if call_id in unsent}
        return lost

    # -- from the server ---------------------------------------------------------------------------------------------

    def receive(self, frame: str | bytes) -> ServerOperation | None:
        """Decode a frame; return None for the response to a call that is no longer pending.

        Raises
        ------
        MalformedMessage
            The frame is not an operation that a rosbridge server sends.
        """
        try:
            operation = _decoder.decode(frame)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise MalformedMessage(f"not an operation of a rosbridge server: {error}") from error
        if isinstance(operation, ServiceResult) and self._calls.pop(operation.id or "", None) is None:
            return None
        return operation


def failure_of(response: ServiceResult) -> PPaaSError | None:
    """Return the error of a failed call, or None if the call succeeded."""
    if response.result:
        return None
    reason = msgspec.json.decode(response.values)
    return error_of_text(reason if isinstance(reason, str) else f"{response.service!r} failed without a reason")


def _text(operation: Operation) -> str:
    return _encoder.encode(operation).decode()
