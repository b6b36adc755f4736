"""Requests of Foxglove's clients: operations as JSON, and binary frames with messages and calls."""

import struct
from typing import Annotated, Any, Final, TypeAlias, get_args

import msgspec

from ppaas.errors import MalformedMessage, PPaaSError

MAX_LISTED = 10_000
"""Largest number of items in one list of a request."""

MAX_TEXT = 4096
"""Longest name in a request [characters]."""

MESSAGE_DATA, SERVICE_CALL = 1, 2
"""First bytes of binary frames of clients."""

_ID = struct.Struct("<I")
_CALL = struct.Struct("<III")

Id = Annotated[int, msgspec.Meta(ge=0, le=2**32 - 1)]
"""Number that a client or the server chooses."""

_Text = Annotated[str, msgspec.Meta(max_length=MAX_TEXT)]
_Listed = msgspec.Meta(max_length=MAX_LISTED)
_Names = Annotated[list[_Text], _Listed]


class Request(msgspec.Struct, frozen=True, tag_field="op", rename="camel"):
    """Base of the operations; fields that are not listed are ignored."""


class ChannelSubscription(msgspec.Struct, frozen=True, rename="camel"):
    """Subscription to a channel, with the id that its messages carry."""

    id: Id
    channel_id: Id


class SubscribeChannels(Request, frozen=True, tag="subscribe"):
    """Subscribe to channels."""

    subscriptions: Annotated[list[ChannelSubscription], _Listed]


class UnsubscribeChannels(Request, frozen=True, tag="unsubscribe"):
    """End subscriptions."""

    subscription_ids: Annotated[list[Id], _Listed]


class ClientChannel(msgspec.Struct, frozen=True, rename="camel"):
    """Channel that a client publishes."""

    id: Id
    topic: _Text
    encoding: _Text
    schema_name: _Text


class AdvertiseChannels(Request, frozen=True, tag="advertise"):
    """Open channels of the client."""

    channels: Annotated[list[ClientChannel], _Listed]


class UnadvertiseChannels(Request, frozen=True, tag="unadvertise"):
    """Close channels of the client."""

    channel_ids: Annotated[list[Id], _Listed]


class GetParameters(Request, frozen=True, tag="getParameters"):
    """Read parameters; without names, all."""

    parameter_names: _Names
    id: _Text | None = None


class Parameter(msgspec.Struct, frozen=True, omit_defaults=True):
    """Parameter; ``type`` separates 64-bit numbers from integers, and bytes from text. One without a value is unset."""

    name: _Text
    value: Any = msgspec.UNSET
    type: str | None = None


class SetParameters(Request, frozen=True, tag="setParameters"):
    """Set parameters; one without a value is removed."""

    parameters: Annotated[list[Parameter], _Listed]
    id: _Text | None = None


class SubscribeParameterUpdates(Request, frozen=True, tag="subscribeParameterUpdates"):
    """Ask for the values of parameters that change; without names, of all."""

    parameter_names: _Names


class UnsubscribeParameterUpdates(Request, frozen=True, tag="unsubscribeParameterUpdates"):
    """End the updates of parameters; without names, of all."""

    parameter_names: _Names


class SubscribeConnectionGraph(Request, frozen=True, tag="subscribeConnectionGraph"):
    """Ask for the graph of nodes, and its changes."""


class UnsubscribeConnectionGraph(Request, frozen=True, tag="unsubscribeConnectionGraph"):
    """End the updates of the graph."""


class FetchAsset(Request, frozen=True, tag="fetchAsset"):
    """Ask for a file."""

    uri: _Text
    request_id: Id


class MessageData(msgspec.Struct, frozen=True):
    """Message on a channel of the client."""

    channel_id: int
    data: bytes


class FoxgloveServiceCall(msgspec.Struct, frozen=True):
    """Call of a service."""

    service_id: int
    call_id: int
    encoding: str
    data: bytes


class RefusedCall(msgspec.Struct, frozen=True):
    """Call that cannot be read, with the ids that its failure is sent by."""

    service_id: int
    call_id: int
    error: PPaaSError


Operation: TypeAlias = (
    SubscribeChannels
    | UnsubscribeChannels
    | AdvertiseChannels
    | UnadvertiseChannels
    | GetParameters
    | SetParameters
    | SubscribeParameterUpdates
    | UnsubscribeParameterUpdates
    | SubscribeConnectionGraph
    | UnsubscribeConnectionGraph
    | FetchAsset
)

OPERATIONS: Final = tuple(kind.__struct_config__.tag for kind in get_args(Operation))
"""Names of the operations that are read."""

_decoder = msgspec.json.Decoder(Operation)


class _Named(msgspec.Struct):
    op: str


_named = msgspec.json.Decoder(_Named)


def read_request(frame: str | bytes) -> Operation | MessageData | FoxgloveServiceCall | RefusedCall | None:
    """Return the request in a frame, ``bytes`` for a binary one; None for an operation that this version ignores.

    A call that cannot be read is returned, too, as far as its ids can: its client waits for an answer.

    Raises
    ------
    MalformedMessage
        It is not a request of the protocol; the text names the place.
    """
    if isinstance(frame, bytes):
        return _read_binary(frame)
    try:
        operation: Operation = _decoder.decode(frame)
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        if _is_unknown(frame):
            return None
        raise MalformedMessage(f"not an operation of Foxglove's protocol: {error}") from error
    return operation


def _is_unknown(text: str) -> bool:
    """Return whether a text is an operation of another version, which servers ignore as the specification says."""
    try:
        return _named.decode(text).op not in OPERATIONS
    except (msgspec.DecodeError, UnicodeError, RecursionError):
        return False


def _read_binary(frame: bytes) -> MessageData | FoxgloveServiceCall | RefusedCall:
    if not frame:
        raise MalformedMessage("an empty binary frame")
    try:
        if frame[0] == MESSAGE_DATA:
            return MessageData(_ID.unpack_from(frame, 1)[0], frame[1 + _ID.size :])
        if frame[0] == SERVICE_CALL:
            return _read_call(frame)
    except (struct.error, UnicodeDecodeError) as error:
        raise MalformedMessage(f"a binary frame of {len(frame)} bytes is too short, or no text: {error}") from error
    raise MalformedMessage(f"unknown binary operation {frame[0]}; known: {MESSAGE_DATA} message, {SERVICE_CALL} call")


def _read_call(frame: bytes) -> FoxgloveServiceCall | RefusedCall:
    service, call, length = _CALL.unpack_from(frame, 1)
    begin = 1 + _CALL.size
    if length > min(MAX_TEXT, len(frame) - begin):
        text = f"the encoding of a call has {length} bytes, and {len(frame) - begin} follow"
        return RefusedCall(service, call, MalformedMessage(text))
    try:
        encoding = frame[begin : begin + length].decode()
    except UnicodeDecodeError as error:
        return RefusedCall(service, call, MalformedMessage(f"the encoding of a call is no text: {error}"))
    return FoxgloveServiceCall(service, call, encoding, frame[begin + length :])
