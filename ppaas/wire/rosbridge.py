"""Server side of rosbridge v2: decodes frames into typed operations, and encodes frames as UTF-8 text.

Source: ``ROSBRIDGE_PROTOCOL.md`` of ``RobotWebTools/rosbridge_suite``. The content of messages is not decoded here; it
stays the client's JSON, which the clone reads.

Two properties of clients shape it. Clients dispatch on the exact string that they subscribed with, so names are sent as
the client spelled them. ``roslibpy`` fails on a ``status``, so it is sent only to clients that requested it by
``set_level``.

A frame that rosbridge_suite would not take either is refused with its id, so that a client which waits for an answer to
a call or a goal gets one.

A client dispatches on the string it subscribed with. So several subscriptions with the same string form one *channel*,
which, as in rosbridge, has the lowest of their throttle rates, the longest of their queues, and the strongest of their
compressions.
"""

from collections import deque
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

import msgspec

from ppaas.errors import MalformedMessage, PPaaSError, QuotaExceeded
from ppaas.messages.base.spelling import split_json, to_ros2, to_standard_json
from ppaas.wire.binary.cbor import RosType
from ppaas.wire.binary.packing import PLAIN, Packer, Packing, json_frame, operation_of
from ppaas.wire.fragments import FragmentAssembler, size_of
from ppaas.wire.names import NameScope, is_ros2_type, ros1_type, ros2_spelling
from ppaas.wire.operations import (
    CLIENT_OPERATIONS,
    LEVELS,
    CallService,
    ClientOperation,
    Fragment,
    Id,
    Level,
    RefusedOperation,
    SetLevel,
    Subscribe,
    Unsubscribe,
)

# -- frames of clients as operations -----------------------------------------------------------------------------------

_decoder: msgspec.json.Decoder[ClientOperation] = msgspec.json.Decoder(ClientOperation)
_KNOWN = f"it is one of: {', '.join(CLIENT_OPERATIONS)}"


MAX_SHOWN = 1024
"""Largest value of a field of a refused frame that is read [bytes of JSON]: an id is sent back, a name is quoted."""

MAX_PARTS = 100
"""Largest number of operations in one frame, one after the other."""

_NULL = msgspec.Raw(b"null")


class _Head(msgspec.Struct):
    op: msgspec.Raw = _NULL
    id: msgspec.Raw = _NULL
    topic: msgspec.Raw = _NULL
    service: msgspec.Raw = _NULL
    action: msgspec.Raw = _NULL


_head_decoder = msgspec.json.Decoder(_Head)
_shown_decoder: msgspec.json.Decoder[Id] = msgspec.json.Decoder(Id)

_NOT_SERVED = {
    "png": "send JSON",
    "auth": "this connection is logged in by the token of its handshake, and needs no secret of rosauth; the token "
    "comes as 'Authorization: Bearer TOKEN', in ws://USER:TOKEN@HOST/?robot=ID, as a ticket, or as '&token=TOKEN'",
}
"""Operations of rosbridge that are refused, each with advice."""


def decode_operation(frame: str | bytes) -> ClientOperation | RefusedOperation:
    """Decode a frame."""
    try:
        operation = _decoder.decode(frame)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        return _decode_tolerantly(frame, error)
    if isinstance(operation, CallService) and operation.id is None:
        operation.id = operation.service.partition("#")[2] or None  # as old clients append it
    return operation


def _decode_tolerantly(frame: str | bytes, error: Exception) -> ClientOperation | RefusedOperation:
    try:
        head = _head_decoder.decode(frame)
    except (msgspec.DecodeError, UnicodeError, RecursionError):
        pass
    else:
        return _refused(head, error)  # it is JSON by the standard, so the fault is in its fields
    try:
        standard = to_standard_json(frame)
        return _decoder.decode(standard)
    except MalformedMessage as malformed:
        parts = split_json(frame, MAX_PARTS)
        return RefusedOperation(MalformedMessage(f"not a rosbridge operation: {malformed}"), parts=parts)
    except msgspec.ValidationError as invalid:
        return _refused_of(standard, invalid)


def _refused_of(standard: bytes, error: Exception) -> RefusedOperation:
    try:
        head = _head_decoder.decode(standard)
    except msgspec.ValidationError:  # it is no object
        head = _Head()
    return _refused(head, error)


def _refused(head: _Head, error: Exception) -> RefusedOperation:
    op = _shown(head.op)
    names = [name for field in (head.topic, head.service, head.action) if isinstance(name := _shown(field), str)]
    reason = MalformedMessage(_reason(op, error))
    return RefusedOperation(reason, op if isinstance(op, str) else "", _shown(head.id), (names or [""])[0])


def _shown(field: msgspec.Raw) -> Id:
    """Return a field that is a short string or an integer; None for anything else."""
    try:
        return _shown_decoder.decode(field) if len(bytes(field)) <= MAX_SHOWN else None
    except (msgspec.DecodeError, UnicodeError):
        return None


def _reason(op: Id, error: Exception) -> str:
    if isinstance(op, str) and op not in CLIENT_OPERATIONS:
        return f"unknown operation {op[:64]!r}: {_NOT_SERVED.get(op, _KNOWN)}"
    if op is None:
        return f"not a rosbridge operation: a frame is a JSON object with the field 'op'; {_KNOWN}"
    return f"not a rosbridge operation: {error}"


# -- subscriptions of one client to one topic --------------------------------------------------------------------------

Respell: TypeAlias = Callable[[bytes], bytes]
"""Called with a message as JSON; returns it as the client expects."""

MAX_QUEUE = 1000
"""Limit of the queue of one channel [messages]."""


@dataclass(frozen=True, slots=True)
class Subscription:
    """Options of one subscription.

    Parameters
    ----------
    spelling : str
        Name of the topic as the client spelled it.
    throttle : float
        Least time between two messages [s].
    queue_length : int
        Length of the queue of throttled messages; 0 keeps only the newest message.
    respell : callable, optional
        Spells a message as the client expects.
    fragment_size : int
        Length of messages from which they are sent in fragments [characters]; 0 for never.
    packing : Packing
        Packs the messages as the client asked for.
    """

    spelling: str
    throttle: float = 0.0
    queue_length: int = 0
    respell: Respell | None = None
    fragment_size: int = 0
    packing: Packing = PLAIN


@dataclass(slots=True, eq=False)
class TopicChannel:
    """Messages of a topic for the client, under one spelling of the topic."""

    spelling: str
    throttle: float = 0.0
    respell: Respell | None = None
    packing: Packing = PLAIN
    waiting: deque[bytes] = field(default_factory=deque)
    next_at: float = float("-inf")

    def settle(self, subscriptions: list[Subscription]) -> None:
        """Combine the options of these subscriptions, the newest of which is the last."""
        self.throttle = min(s.throttle for s in subscriptions)
        self.respell = subscriptions[-1].respell
        self.packing = max((s.packing for s in subscriptions), key=lambda packing: packing.rank)
        length = min(max(s.queue_length for s in subscriptions), MAX_QUEUE)
        self.waiting = deque(self.waiting, maxlen=max(length, 1))

    def frame_of(self, payload: bytes) -> bytes:
        """Return the frame of a message; JSON if it cannot be packed otherwise, as a client's message may be."""
        text = payload if self.respell is None else self.respell(payload)
        try:
            return self.packing.pack(self.spelling, text)
        except (PPaaSError, msgspec.MsgspecError, ValueError, RecursionError):
            return json_frame(self.spelling, text)

    def take(self, payload: bytes, now: float) -> bytes | None:
        """Add a message; return the message to send now, or None if it must wait.

        A full queue drops its oldest message. So the last message of a series is always delivered.
        """
        if self.throttle <= 0.0 and not self.waiting:
            return payload
        self.waiting.append(payload)
        return self.due(now)

    def due(self, now: float) -> bytes | None:
        """Return a queued message that is due, if there is one."""
        if not self.waiting or now < self.next_at:
            return None
        self.next_at = now + self.throttle
        return self.waiting.popleft()


class TopicSubscriptions:
    """Subscriptions of one client to one topic."""

    def __init__(self) -> None:
        self._by_id: dict[Id, Subscription] = {}
        self._channels: dict[str, TopicChannel] = {}

    def __len__(self) -> int:
        """Return the number of subscriptions."""
        return len(self._by_id)

    def __iter__(self) -> Iterator[TopicChannel]:
        """Iterate over the channels."""
        return iter(self._channels.values())

    def add(self, subscription_id: Id, subscription: Subscription) -> None:
        """Add a subscription, or replace the one with the same id."""
        self._by_id.pop(subscription_id, None)
        self._by_id[subscription_id] = subscription
        self._settle()

    def remove(self, subscription_id: Id) -> None:
        """Remove the subscription with an id; None removes all."""
        if subscription_id is None:
            self._by_id.clear()
        else:
            self._by_id.pop(subscription_id, None)
        self._settle()

    def _settle(self) -> None:
        by_spelling: dict[str, list[Subscription]] = {}
        for subscription in self._by_id.values():
            by_spelling.setdefault(subscription.spelling, []).append(subscription)
        self._channels = {spelling: self._channels.get(spelling, TopicChannel(spelling)) for spelling in by_spelling}
        for spelling, subscriptions in by_spelling.items():
            self._channels[spelling].settle(subscriptions)

    @property
    def fragment_size(self) -> int:
        """Least size from which messages are sent in fragments [characters]; 0 if there is none."""
        return min((s.fragment_size for s in self._by_id.values() if s.fragment_size), default=0)

    @property
    def queue_length(self) -> int:
        """Longest requested queue [messages]; 0 if none was requested."""
        return max((s.queue_length for s in self._by_id.values()), default=0)


# -- the server side of rosbridge v2 -----------------------------------------------------------------------------------

MAX_SUBSCRIPTIONS = 500
"""Limit of subscriptions of one client; the dashboard needs about a dozen."""

_encoder = msgspec.json.Encoder()


class _ServiceResponse(msgspec.Struct, tag_field="op", tag="service_response", omit_defaults=False):
    service: str
    values: msgspec.Raw | str
    result: bool
    id: Id = None


class _ServiceRequest(msgspec.Struct, tag_field="op", tag="call_service"):
    service: str
    id: str
    args: msgspec.Raw


class _Status(msgspec.Struct, tag_field="op", tag="status"):
    level: str
    msg: str
    id: Id = None


def _type_of(operation: Subscribe) -> RosType:
    return RosType(ros1_type(operation.type) if operation.type else None, is_ros2_type(operation.type))


class RosbridgeSession:
    """Protocol state of one client: its subscriptions and its status level.

    Parameters
    ----------
    level : {"none", "error", "warning", "info"}
        Initial status level, as if the client had sent ``set_level``.
    names : NameScope, optional
        Reads the names that the client spells.
    packer : Packer, optional
        Chooses how messages are packed for the client.

    Attributes
    ----------
    spelling_of : callable
        Called with the topic and the type of a subscription; returns what spells messages for it, or None.
    """

    def __init__(self, level: Level = "none", names: NameScope | None = None, packer: Packer | None = None) -> None:
        self._level: Level = level
        self.names = names or NameScope()
        self.packer = packer or Packer()
        self.spelling_of: Callable[[str, str | None], Respell | None] = lambda _topic, kind: ros2_spelling(kind)
        self._fragments = FragmentAssembler()
        self._subscriptions: dict[str, TopicSubscriptions] = {}
        self._late: dict[TopicChannel, str] = {}

    # -- from the client ---------------------------------------------------------------------------------------------

    def receive_binary(self, frame: bytes) -> ClientOperation | RefusedOperation:
        """Decode a binary frame like ``receive``: JSON, CBOR of an operation, or a compact frame."""
        try:
            text = operation_of(frame)
        except PPaaSError as error:
            return RefusedOperation(error)
        return self.receive(text)

    def receive(self, text: str | bytes) -> ClientOperation | RefusedOperation:
        """Decode a frame of text, ``bytes`` in UTF-8, and update the subscriptions and the status level.

        An invalid frame changes nothing.
        """
        operation = decode_operation(text)
        if isinstance(operation, Fragment):
            operation = self._add(operation)
        if isinstance(operation, SetLevel):
            self._level = operation.level
        elif isinstance(operation, Subscribe | Unsubscribe):
            try:
                self._change(operation)
            except PPaaSError as error:  # not a name of a topic, or too many subscriptions
                return RefusedOperation(error, id=operation.id, name=operation.topic)
        return operation

    @property
    def incomplete(self) -> Collection[Id]:
        """Ids of the frames of which the client has sent only some fragments."""
        return self._fragments.incomplete

    def _add(self, fragment: Fragment) -> ClientOperation | RefusedOperation:
        """Add a part of a frame; return the operation of the frame if that completes it."""
        try:
            frame = self._fragments.add(fragment)
        except PPaaSError as error:
            return RefusedOperation(error, id=fragment.id)
        operation = fragment if frame is None else decode_operation(frame)
        if frame is not None and isinstance(operation, Fragment):
            return RefusedOperation(MalformedMessage("fragments must not be in fragments"), id=fragment.id)
        return operation

    def _change(self, operation: Subscribe | Unsubscribe) -> None:
        if isinstance(operation, Subscribe):
            self._subscribe(operation)
        else:
            self._unsubscribe(operation)

    def _subscribe(self, operation: Subscribe) -> None:
        topic = self.names.resolve(operation.topic)
        if sum(map(len, self._subscriptions.values())) >= MAX_SUBSCRIPTIONS:
            raise QuotaExceeded(f"a client may have at most {MAX_SUBSCRIPTIONS} subscriptions: unsubscribe some first")
        throttle, queue_length = max(operation.throttle_rate or 0.0, 0.0) / 1000.0, max(operation.queue_length or 0, 0)
        subscription = Subscription(
            operation.topic, throttle, queue_length, self.spelling_of(topic, operation.type), size_of(operation),
            self.packer.packing_of(topic, operation.compression, _type_of(operation)),
        )  # fmt: skip
        self._subscriptions.setdefault(topic, TopicSubscriptions()).add(operation.id, subscription)
        self._forget_late()

    def objection(self, operation: Subscribe) -> PPaaSError | None:
        """Return the reason why a subscription gets JSON in place of its compression; None if it does not."""
        topic = self.names.resolve(operation.topic)
        return self.packer.objection(topic, operation.compression, _type_of(operation))

    def _unsubscribe(self, operation: Unsubscribe) -> None:
        topic = self.names.resolve(operation.topic)
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
        """Return the topics with a subscription, without leading slashes."""
        return frozenset(self._subscriptions)

    def hears(self, topic: str) -> bool:
        """Return whether the client subscribes to a topic, given without a leading slash."""
        return topic in self._subscriptions

    def forget(self, operation: Subscribe) -> None:
        """Remove a subscription that was refused, and with it an earlier one of the same id."""
        self._unsubscribe(Unsubscribe(operation.topic, operation.id))

    def queue_length(self, topic: str, default: int) -> int:
        """Return how many messages of a topic are queued for this client before the oldest is dropped."""
        subscriptions = self._subscriptions.get(topic)
        return (subscriptions.queue_length if subscriptions is not None else 0) or default

    def fragment_size(self, topic: str) -> int:
        """Return the least ``fragment_size`` of the subscriptions to a topic [characters]; 0 if none has one."""
        subscriptions = self._subscriptions.get(topic)
        return subscriptions.fragment_size if subscriptions is not None else 0

    # -- to the client -----------------------------------------------------------------------------------------------

    def publish(self, topic: str, payload: bytes, now: float) -> Iterator[bytes]:
        """Yield the frames of a message for this client, one for each spelling of the topic that it subscribed with.

        Parameters
        ----------
        topic : str
            Name of the topic, without a leading slash.
        payload : bytes
            The message as JSON.
        now : float
            Monotonic time [s], for ``throttle_rate``. A message that comes too soon is queued for ``due``.
        """
        for channel in self._subscriptions.get(topic, ()):
            ready = channel.take(payload, now)
            if channel.waiting:
                self._late[channel] = topic
            if ready is not None:
                yield channel.frame_of(ready)

    def next_due(self) -> float | None:
        """Return the monotonic time at which ``due`` yields the next message [s]; None if the queues are empty."""
        return min((channel.next_at for channel in self._late), default=None)

    def due(self, now: float) -> Iterator[tuple[str, bytes]]:
        """Yield topics and frames of queued messages that are due."""
        for channel, topic in tuple(self._late.items()):
            ready = channel.due(now)
            if not channel.waiting:
                del self._late[channel]
            if ready is not None:
                yield topic, channel.frame_of(ready)

    def answer(self, call: CallService, values: bytes) -> bytes:
        """Return the frame with the response to a call; ``values`` is JSON."""
        if is_ros2_type(call.type):
            values = to_ros2(values)
        return _encoder.encode(_ServiceResponse(call.service, msgspec.Raw(values), True, call.id))

    def refuse_call(self, call: CallService, error: PPaaSError) -> bytes:
        """Return the frame that reports the failure of a call; its ``values`` are the reason as text."""
        return _encoder.encode(_ServiceResponse(call.service, error.public, False, call.id))

    def request(self, service: str, call: int, arguments: bytes) -> bytes:
        """Return the frame that requests the client to serve a call; ``service`` is spelled as the client did."""
        return _encoder.encode(_ServiceRequest(service, str(call), msgspec.Raw(arguments)))

    def status(
        self, error: PPaaSError, operation_id: Id = None, level: Level = "error", *, always: bool = False
    ) -> bytes | None:
        """Return the frame that reports an error, or None if the client's status level excludes it.

        Parameters
        ----------
        error : PPaaSError
        operation_id : str or int, optional
            Id of the operation that caused it.
        level : {"error", "warning", "info"}
        always : bool
            Whether to report it whatever level the client has: it would wait for an answer in vain otherwise.
        """
        if not always and LEVELS.index(self._level) < LEVELS.index(level):
            return None
        return _encoder.encode(_Status(level, f"{error.slug}: {error.public}", operation_id))
