"""The client side of rosbridge v2: what a robot or an operator says, and what it is told. Frames in, events out.

The frames themselves are those of the server side, ``ppaas.wire.rosbridge``. A session outlives its connections: it
remembers what was subscribed and offered, so that a client that lost its connection can say so again on the next.
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
    """A message of a topic that the client subscribed to; ``msg`` is its JSON."""

    topic: str
    msg: msgspec.Raw


class ServiceResult(Operation, tag="service_response"):
    """What a service answered; where ``result`` is false, ``values`` is the reason as text."""

    service: str
    result: bool
    values: msgspec.Raw = msgspec.Raw(b"{}")
    id: str | None = None


class StatusReport(Operation, tag="status"):
    """The server could not do what the client asked."""

    level: str
    msg: str
    id: str | None = None

    def error(self) -> PPaaSError:
        """Return what the server told of, as an error."""
        return error_of_text(self.msg)


ServerOperation = ReceivedMessage | ServiceResult | StatusReport | CallService

_decoder: msgspec.json.Decoder[ServerOperation] = msgspec.json.Decoder(ServerOperation)


class RosbridgeClientSession:
    """What one client wants of the cloud, over all its connections."""

    def __init__(self) -> None:
        self._subscriptions: dict[str, Subscribe] = {}
        self._offers: dict[str, AdvertiseService] = {}
        self._calls: dict[str, str] = {}
        self._sequence = itertools.count(1)

    # -- what the client says ----------------------------------------------------------------------------------------

    def subscribe(self, topic: str, kind: type[Message], throttle: float = 0.0, queue_length: int = 0) -> str:
        """Return the frame that subscribes to a topic; subscribing again changes how it is heard.

        Parameters
        ----------
        topic : str
            With or without a leading slash.
        kind : type of Message
            What the topic carries.
        throttle : float
            Hear it at most once in this many seconds.
        queue_length : int
            Messages that the cloud keeps while the link is slow; 0 leaves it to the cloud.

        Raises
        ------
        MalformedMessage
            Not a ROS graph name.
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
            Not a ROS graph name.
        """
        normalise(topic)
        return _text(Publish(topic, msgspec.Raw(encode(message))))

    def call(self, service: str, request: Message) -> tuple[str, str]:
        """Return the id of a new call and its frame.

        Raises
        ------
        MalformedMessage
            Not a ROS graph name.
        """
        normalise(service)
        call_id = f"call:{next(self._sequence)}"
        self._calls[call_id] = service
        return call_id, _text(CallService(service, id=call_id, args=msgspec.Raw(encode(request))))

    def give_up(self, call_id: str) -> None:
        """Wait no longer for the answer to a call."""
        self._calls.pop(call_id, None)

    def advertise_service(self, service: str, kind: ServiceType) -> str:
        """Return the frame that offers a service.

        Raises
        ------
        MalformedMessage
            Not a ROS graph name.
        """
        offer = self._offers[normalise(service)] = AdvertiseService(service, kind.name)
        return _text(offer)

    def unadvertise_service(self, service: str) -> str:
        """Return the frame that ends the offer of a service."""
        self._offers.pop(normalise(service), None)
        return _text(UnadvertiseService(service))

    def respond(self, call: CallService, response: Message) -> str:
        """Return the frame that answers a call of a service that is offered here."""
        values = msgspec.Raw(encode(response))
        return _text(operations.ServiceResponse(call.service, result=True, values=values, id=call.id))

    def refuse(self, call: CallService, error: PPaaSError) -> str:
        """Return the frame that says why a call of a service that is offered here has no answer."""
        reason = msgspec.Raw(_encoder.encode(f"{error.slug}: {error}"))
        return _text(operations.ServiceResponse(call.service, result=False, values=reason, id=call.id))

    def reconnected(self) -> list[str]:
        """Return the frames with which a new connection begins: what was subscribed and offered before."""
        return [_text(wanted) for wanted in (*self._subscriptions.values(), *self._offers.values())]

    def disconnected(self, unsent: Collection[str] = ()) -> dict[str, Unavailable]:
        """Return the calls that were lost with the connection, each with its error; they are not waited for.

        Parameters
        ----------
        unsent : collection of str
            Calls that the lost connection had not carried yet: they are still to be made.
        """
        lost = {
            call_id: Unavailable(f"the connection was lost while {service!r} was called; call again")
            for call_id, service in self._calls.items()
            if call_id not in unsent
        }
        self._calls = {call_id: service for call_id, service in self._calls.items() if call_id in unsent}
        return lost

    # -- what the client is told -------------------------------------------------------------------------------------

    def receive(self, frame: str | bytes) -> ServerOperation | None:
        """Read one frame; None is an answer to a call that is no longer waited for.

        Raises
        ------
        MalformedMessage
            Not a frame that a rosbridge server sends.
        """
        try:
            operation = _decoder.decode(frame)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise MalformedMessage(f"not an operation of a rosbridge server: {error}") from error
        if isinstance(operation, ServiceResult) and self._calls.pop(operation.id or "", None) is None:
            return None
        return operation


def failure_of(response: ServiceResult) -> PPaaSError | None:
    """Return why a call failed, or None if it did not."""
    if response.result:
        return None
    reason = msgspec.json.decode(response.values)
    return error_of_text(reason if isinstance(reason, str) else f"{response.service!r} failed without a reason")


def _text(operation: Operation) -> str:
    return _encoder.encode(operation).decode()
