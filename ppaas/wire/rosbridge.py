"""The server side of rosbridge v2: frames of text in, typed operations out, and back: text in UTF-8, as it is sent.

Source of the facts: ``RobotWebTools/rosbridge_suite``, ``ROSBRIDGE_PROTOCOL.md``. What a message carries is not looked
at here: it stays the JSON that the client sent, for the clone to read.

Two habits of clients shape it. They dispatch on the very string that they subscribed with, so a name is echoed as it
was spelled; and ``roslibpy`` cannot take a ``status``, so one is sent only to a client that asked with ``set_level``.
"""

from collections.abc import Iterator

import msgspec

from ppaas.errors import MalformedMessage, PPaaSError, QuotaExceeded
from ppaas.messages.time_spelling import to_ros2
from ppaas.wire.names import is_ros2_type, normalise
from ppaas.wire.operations import LEVELS, CallService, ClientOperation, Level, SetLevel, Subscribe, Unsubscribe
from ppaas.wire.subscriptions import Channel, Subscription, TopicSubscriptions

MAX_SUBSCRIPTIONS = 500
"""Of one client; an unmodified web page needs a dozen."""

_decoder: msgspec.json.Decoder[ClientOperation] = msgspec.json.Decoder(ClientOperation)
_encoder = msgspec.json.Encoder()


class _ServiceResponse(msgspec.Struct, tag_field="op", tag="service_response", omit_defaults=False):
    service: str
    values: msgspec.Raw | str
    result: bool
    id: str | None = None


class _ServiceRequest(msgspec.Struct, tag_field="op", tag="call_service"):
    service: str
    id: str
    args: msgspec.Raw


class _Status(msgspec.Struct, tag_field="op", tag="status"):
    level: str
    msg: str
    id: str | None = None


class RosbridgeSession:
    """What one client and the cloud have said to each other so far.

    Parameters
    ----------
    level : {"none", "error", "warning", "info"}
        Tell the client of errors from the start, as if it had sent ``set_level``.
    """

    def __init__(self, level: Level = "none") -> None:
        self._level: Level = level
        self._subscriptions: dict[str, TopicSubscriptions] = {}
        self._late: dict[Channel, str] = {}

    # -- what the client says ----------------------------------------------------------------------------------------

    def receive(self, frame: str | bytes) -> ClientOperation:
        """Read one frame, and note what it says about subscriptions and the status level.

        Raises
        ------
        MalformedMessage
            Not JSON, no such operation, a field missing or of the wrong type.
        UnknownType
            A subscription with what cannot be a type.
        QuotaExceeded
            Too many subscriptions.
        """
        try:
            operation = _decoder.decode(frame)
        except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
            raise MalformedMessage(f"not an operation of rosbridge: {error}") from error
        if isinstance(operation, Subscribe):
            self._subscribe(operation)
        elif isinstance(operation, Unsubscribe):
            self._unsubscribe(operation)
        elif isinstance(operation, SetLevel):
            self._level = operation.level
        return operation

    def _subscribe(self, operation: Subscribe) -> None:
        if operation.throttle_rate < 0 or operation.queue_length < 0:
            raise MalformedMessage("throttle_rate and queue_length must not be negative")
        topic = normalise(operation.topic)
        if sum(map(len, self._subscriptions.values())) >= MAX_SUBSCRIPTIONS:
            raise QuotaExceeded(f"a client has at most {MAX_SUBSCRIPTIONS} subscriptions: unsubscribe some first")
        throttle, ros2 = operation.throttle_rate / 1000.0, is_ros2_type(operation.type)
        subscription = Subscription(operation.topic, throttle, operation.queue_length, ros2)
        self._subscriptions.setdefault(topic, TopicSubscriptions()).add(operation.id, subscription)
        self._forget_late()

    def _unsubscribe(self, operation: Unsubscribe) -> None:
        topic = normalise(operation.topic)
        subscriptions = self._subscriptions.get(topic)
        if subscriptions is None:
            return
        subscriptions.remove(operation.id)
        if not subscriptions:
            del self._subscriptions[topic]
        self._forget_late()

    def _forget_late(self) -> None:
        heard = {channel for subscriptions in self._subscriptions.values() for channel in subscriptions}
        self._late = {channel: topic for channel, topic in self._late.items() if channel in heard}

    def subscribed(self) -> frozenset[str]:
        """Return the topics that the client hears now, without leading slashes."""
        return frozenset(self._subscriptions)

    def hears(self, topic: str) -> bool:
        """Tell whether the client hears a topic, given without a leading slash."""
        return topic in self._subscriptions

    def forget(self, operation: Subscribe) -> None:
        """Drop a subscription that was refused; an earlier one of the same id goes with it."""
        self._unsubscribe(Unsubscribe(operation.topic, operation.id))

    def queue_length(self, topic: str, default: int) -> int:
        """Return how many messages of a topic wait for this client before the oldest are dropped."""
        subscriptions = self._subscriptions.get(topic)
        return (subscriptions.queue_length if subscriptions is not None else 0) or default

    # -- what the client is told -------------------------------------------------------------------------------------

    def publish(self, topic: str, payload: bytes, now: float) -> Iterator[bytes]:
        """Yield the frames that bring a message to this client, one for each spelling that it subscribed with.

        Parameters
        ----------
        topic : str
            Without a leading slash.
        payload : bytes
            The message as JSON.
        now : float
            Monotonic seconds, for ``throttle_rate``. What comes too soon waits for ``due``.
        """
        for channel in self._subscriptions.get(topic, ()):
            ready = channel.take(payload, now)
            if channel.waiting:
                self._late[channel] = topic
            if ready is not None:
                yield _published(channel, ready)

    def next_due(self) -> float | None:
        """Return when ``due`` has the next message, in monotonic seconds; None if nothing waits."""
        return min((channel.next_at for channel in self._late), default=None)

    def due(self, now: float) -> Iterator[tuple[str, bytes]]:
        """Yield topics and frames of messages that came too soon, and whose turn it is now."""
        for channel, topic in tuple(self._late.items()):
            ready = channel.due(now)
            if not channel.waiting:
                del self._late[channel]
            if ready is not None:
                yield topic, _published(channel, ready)

    def answer(self, call: CallService, values: bytes) -> bytes:
        """Return the response of a service that was served; ``values`` is JSON."""
        if is_ros2_type(call.type):
            values = to_ros2(values)
        return _encoder.encode(_ServiceResponse(call.service, msgspec.Raw(values), True, call.id))

    def refuse_call(self, call: CallService, error: PPaaSError) -> bytes:
        """Return the response of a service that failed: the reason takes the place of the values."""
        return _encoder.encode(_ServiceResponse(call.service, str(error), False, call.id))

    def request(self, service: str, call: int, arguments: bytes) -> bytes:
        """Return the frame that asks the client to serve a call; ``service`` is spelled as it was advertised."""
        return _encoder.encode(_ServiceRequest(service, str(call), msgspec.Raw(arguments)))

    def status(self, error: PPaaSError, operation_id: str | None = None, level: Level = "error") -> bytes | None:
        """Return the frame that tells the client of an error, or None if it does not want to hear of one this bad."""
        if LEVELS.index(self._level) < LEVELS.index(level):
            return None
        return _encoder.encode(_Status(level, f"{error.slug}: {error}", operation_id))


def _published(channel: Channel, payload: bytes) -> bytes:
    text = to_ros2(payload) if channel.ros2 else payload
    return b'{"op":"publish","topic":"%b","msg":%b}' % (channel.spelling.encode(), text)
