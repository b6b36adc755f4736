"""Arguments of calls and goals: a JSON object of fields, or a list in the order of the fields."""

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.messages.base.message import Message

_list_decoder: msgspec.json.Decoder[list[msgspec.Raw]] = msgspec.json.Decoder(list[msgspec.Raw])
_encoder = msgspec.json.Encoder()

_NOTHING = b"{}"

MAX_LIST = 1 << 20
"""Largest list of arguments [bytes of JSON], which may have a million values."""


def as_object(arguments: bytes, kind: type[Message] | None) -> bytes:
    """Return arguments as a JSON object.

    Parameters
    ----------
    arguments : bytes
        JSON as received.
    kind : type of Message, optional
        Message type with the fields. If it is None, a list must be empty.

    Raises
    ------
    MalformedMessage
        The arguments are neither an object nor a list, or the list does not match the fields.
    """
    text = arguments.lstrip()
    if text.startswith(b"{"):
        return arguments
    if text == b"null":
        return _NOTHING
    if not text.startswith(b"["):
        raise MalformedMessage("arguments must be an object, or a list in the order of the fields")
    if len(arguments) > MAX_LIST:
        raise MalformedMessage(f"a list of arguments may have {MAX_LIST >> 20} MiB: send an object")
    values = _list_decoder.decode(arguments)
    if not values:
        return _NOTHING
    if kind is None:
        raise MalformedMessage("the definition of this type is not known: send the arguments as an object")
    names = kind.field_names()
    if len(values) > len(names):
        fields = f"{kind.__name__} has {len(names)} fields: {', '.join(names) or 'none'}"
        raise MalformedMessage(f"{len(values)} arguments are too many; {fields}")
    return _encoder.encode(dict(zip(names, values, strict=False)))
