"""The server side of rosbridge v2: frames of text in, typed operations out, and back.

Source of the facts: ``RobotWebTools/rosbridge_suite``, ``ROSBRIDGE_PROTOCOL.md``. What a message carries is not looked
at here: it stays the JSON that the client sent, for the clone to read.

Two habits of clients shape it. They dispatch on the very string that they subscribed with, so a name is echoed as it
was spelled; and ``roslibpy`` cannot take a ``status``, so one is sent only to a client that asked with ``set_level``.
"""

from collections.abc import Iterator
from typing import Literal

import msgspec

from ppaas.errors import MalformedMessage, PPaaSError, QuotaExceeded
from ppaas.wire.names import normalise

Level = Literal["none", "error", "warning", "info"]
_LEVELS: tuple[Level, ...] = ("none", "error", "warning", "info")
_EMPTY = msgspec.Raw(b"{}")

MAX_SUBSCRIPTIONS = 500
"""Of one client; an unmodified web page needs a dozen."""


class Operation(msgspec.Struct, tag_field="op"):
    """One frame of a client."""


class Publish(Operation, tag="publish"):
    """A message for a topic."""

    topic: str
    msg: msgspec.Raw
    id: str | None = None
    latch: bool = False


class Advertise(Operation, tag="advertise"):
    """The client will publish on a topic."""

    topic: str
    type: str
    id: str | None = None
    latch: bool = False
    queue_size: int = 100


class Unadvertise(Operation, tag="unadvertise"):
    """The client will publish no more on a topic."""

    topic: str
    id: str | None = None


class Subscribe(Operation, tag="subscribe"):
    """Hear a topic: at most once in ``throttle_rate`` ms, with ``queue_length`` messages kept for a slow reader."""

    topic: str
    id: str | None = None
    type: str | None = None
    throttle_rate: int = 0
    queue_length: int = 0
    fragment_size: int | None = None
    compression: str = "none"


class Unsubscribe(Operation, tag="unsubscribe"):
    """Hear a topic no more: the subscription of that id, or all of this client's."""

    topic: str
    id: str | None = None


class CallService(Operation, tag="call_service"):
    """Call a service; the arguments are the object of its request."""

    service: str
    id: str | None = None
    args: msgspec.Raw = _EMPTY
    type: str | None = None


class SetLevel(Operation, tag="set_level"):
    """Tell the client of what is this bad or worse, by ``status``."""

    level: Level
    id: str | None = None


ClientOperation = Publish | Advertise | Unadvertise | Subscribe | Unsubscribe | CallService | SetLevel

_decoder: msgspec.json.Decoder[ClientOperation] = msgspec.json.Decoder(ClientOperation)
_encoder = msgspec.json.Encoder()


class _ServiceResponse(msgspec.Struct, tag_field="op", tag="service_response", omit_defaults=False):
    service: str
    values: msgspec.Raw | str
    result: bool
    id: str | None = None


class _Status(msgspec.Struct, tag_field="op", tag="status"):
    level: str
    msg: str
    id: str | None = None


class Subscription(msgspec.Struct):
    """How one client hears one topic."""

    spelling: str
    throttle: float
    queue_length: int
    last_sent: float = float("-inf")


class RosbridgeSession:
    """What one client and the cloud have said to each other so far.

    Parameters
    ----------
    level : {"none", "error", "warning", "info"}
        Tell the client of errors from the start, as if it had sent ``set_level``.
    """

    def __init__(self, level: Level = "none") -> None:
        self._level: Level = level
        self._subscriptions: dict[str, dict[str | None, Subscription]] = {}

    # -- what the client says ----------------------------------------------------------------------------------------

    def receive(self, frame: str | bytes) -> ClientOperation:
        """Read one frame, and note what it says about subscriptions and the status level.

        Raises
        ------
        MalformedMessage
            Not JSON, no such operation, a field missing or of the wrong type.
        QuotaExceeded
            Too many subscriptions.
        """
        try:
            operation = _decoder.decode(frame)
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
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
        subscription = Subscription(operation.topic, operation.throttle_rate / 1000.0, operation.queue_length)
        if sum(map(len, self._subscriptions.values())) >= MAX_SUBSCRIPTIONS:
            raise QuotaExceeded(f"a client has at most {MAX_SUBSCRIPTIONS} subscriptions: unsubscribe some first")
        self._subscriptions.setdefault(normalise(operation.topic), {})[operation.id] = subscription

    def _unsubscribe(self, operation: Unsubscribe) -> None:
        topic = normalise(operation.topic)
        ids = self._subscriptions.get(topic, {})
        if operation.id is None:
            ids.clear()
        else:
            ids.pop(operation.id, None)
        if not ids:
            self._subscriptions.pop(topic, None)

    def subscribed(self) -> frozenset[str]:
        """Return the topics that the client hears now, without leading slashes."""
        return frozenset(self._subscriptions)

    def forget(self, topic: str) -> None:
        """Drop the subscriptions of a topic that was refused."""
        self._subscriptions.pop(topic, None)

    def queue_length(self, topic: str, default: int) -> int:
        """Return how many messages of a topic wait for this client before the oldest are dropped."""
        lengths = [s.queue_length for s in self._subscriptions.get(topic, {}).values()]
        return max(lengths, default=0) or default

    # -- what the client is told -------------------------------------------------------------------------------------

    def publish(self, topic: str, payload: bytes, now: float) -> Iterator[str]:
        """Yield the frames that bring a message to this client, one for each spelling that it subscribed with.

        Parameters
        ----------
        topic : str
            Without a leading slash.
        payload : bytes
            The message as JSON.
        now : float
            Monotonic seconds, for ``throttle_rate``.
        """
        due: set[str] = set()
        for subscription in self._subscriptions.get(topic, {}).values():
            if now - subscription.last_sent >= subscription.throttle:
                subscription.last_sent = now
                due.add(subscription.spelling)
        for spelling in due:
            yield f'{{"op":"publish","topic":"{spelling}","msg":{payload.decode()}}}'

    def answer(self, call: CallService, values: bytes) -> str:
        """Return the response of a service that was served; ``values`` is JSON."""
        return _encoder.encode(_ServiceResponse(call.service, msgspec.Raw(values), True, call.id)).decode()

    def refuse_call(self, call: CallService, error: PPaaSError) -> str:
        """Return the response of a service that failed: the reason takes the place of the values."""
        return _encoder.encode(_ServiceResponse(call.service, str(error), False, call.id)).decode()

    def status(self, error: PPaaSError, operation_id: str | None = None) -> str | None:
        """Return the frame that tells the client of an error, or None if it does not want to hear."""
        if _LEVELS.index(self._level) < _LEVELS.index("error"):
            return None
        return _encoder.encode(_Status("error", f"{error.slug}: {error}", operation_id)).decode()
