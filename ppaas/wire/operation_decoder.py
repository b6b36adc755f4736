"""Frames of clients as operations: strict, and where that fails, as tolerant as rosbridge_suite.

A frame that rosbridge_suite would not take either is refused with its id, so that a client which waits for an answer
to a call or a goal gets one.
"""

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.messages.spellings.tolerant_json import split_json, to_standard_json
from ppaas.wire.operations import CLIENT_OPERATIONS, CallService, ClientOperation, Id, RefusedOperation

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
