"""The arguments of a call or a goal: an object of fields, or a list in the order of the fields."""

import msgspec

from ppaas.errors import MalformedMessage
from ppaas.messages.message import Message

_list_decoder: msgspec.json.Decoder[list[msgspec.Raw]] = msgspec.json.Decoder(list[msgspec.Raw])
_encoder = msgspec.json.Encoder()

_NOTHING = b"{}"


def as_object(arguments: bytes, kind: type[Message] | None) -> bytes:
    """Return arguments as the JSON of an object.

    Parameters
    ----------
    arguments : bytes
        JSON, as it was sent.
    kind : type of Message, optional
        Whose fields they are; None if that is not known, and then a list must be empty.

    Raises
    ------
    MalformedMessage
        Neither an object nor a list, or a list that cannot be matched with the fields.
    """
    text = arguments.lstrip()
    if text.startswith(b"{"):
        return arguments
    if text == b"null":
        return _NOTHING
    if not text.startswith(b"["):
        raise MalformedMessage("arguments are an object, or a list in the order of the fields")
    values = _list_decoder.decode(arguments)
    if not values:
        return _NOTHING
    if kind is None:
        raise MalformedMessage("the fields of this type are not known here: send the arguments as an object")
    names = kind.__struct_encode_fields__
    if len(values) > len(names):
        raise MalformedMessage(f"{len(values)} arguments for {kind.__name__}, which has {len(names)}: {list(names)}")
    return _encoder.encode(dict(zip(names, values, strict=False)))
