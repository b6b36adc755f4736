"""Message definitions, as ``rosapi/TypeDef`` and as text.

Both are derived from the structs, so they are never out of date.
"""

from collections.abc import Iterable
from functools import cache
from typing import NamedTuple

from msgspec import inspect

from ppaas.messages.base.message import NO_ARRAY, Message, message_of, plain, struct_of
from ppaas.messages.base.rosapi import TypeDef
from ppaas.messages.base.std_msgs import Duration, Time
from ppaas.messages.registry import type_name

ANY_LENGTH = 0
_RULE = "=" * 80

# Times are primitive types in ROS 1, but rosapi lists their fields as it does for messages.
_TIMES: dict[type, str] = {Time: "time", Duration: "duration"}
_EXAMPLES = {"bool": "False", "string": "", "float32": "0.0", "float64": "0.0"}


class _Field(NamedTuple):
    name: str
    ros: str
    length: int
    message: type[Message] | None

    def example(self) -> str:
        if self.length != NO_ARRAY:
            return "[]"
        return "{}" if self.message is not None else _EXAMPLES.get(self.ros, "0")

    def text(self) -> str:
        array = {NO_ARRAY: "", ANY_LENGTH: "[]"}.get(self.length, f"[{self.length}]")
        return f"{self.ros}{array} {self.name}"


def typedefs(message: type[Message]) -> list[TypeDef]:
    """Return the definitions of a message and of all messages nested in it, each once."""
    return [_typedef(cls) for cls in _with_nested(message)]


def full_text(message: type[Message]) -> str:
    """Return the definitions of a message and of all messages nested in it, in the format of ``gendeps --cat``."""
    others = [cls for cls in _with_nested(message) if cls is not message and cls not in _TIMES]
    return "\n".join([_text(message), *(f"{_RULE}\nMSG: {type_name(cls)}\n{_text(cls)}" for cls in others)])


def _with_nested(message: type[Message]) -> Iterable[type[Message]]:
    """Return a message type and all types nested in it, depth first, each once."""
    seen: dict[type[Message], None] = {}
    waiting = [message]
    while waiting:
        cls = waiting.pop()
        if cls not in seen:
            seen[cls] = None
            waiting.extend(field.message for field in reversed(_fields(cls)) if field.message is not None)
    return seen


def _name(message: type[Message]) -> str:
    return _TIMES.get(message) or type_name(message)


def _typedef(message: type[Message]) -> TypeDef:
    fields = _fields(message)
    return TypeDef(
        type=_name(message),
        fieldnames=[field.name for field in fields],
        fieldtypes=[field.ros for field in fields],
        fieldarraylen=[field.length for field in fields],
        examples=[field.example() for field in fields],
        constnames=[constant.name for constant in message.constants or ()],
        constvalues=[str(constant.value) for constant in message.constants or ()],
    )


def _text(message: type[Message]) -> str:
    constants = [f"uint8 {constant.name}={constant.value}" for constant in message.constants or ()]
    return "\n".join([*constants, *(field.text() for field in _fields(message)), ""])


@cache
def _fields(message: type[Message]) -> tuple[_Field, ...]:
    types = {field.encode_name: field.type for field in struct_of(message).fields}
    return tuple(_field(name, types[name]) for name in message.field_names())


def _field(name: str, kind: inspect.Type) -> _Field:
    kind, length, ros = plain(kind)
    if isinstance(kind, inspect.ListType):
        item, _, ros = plain(kind.item_type)
        kind, length = item, max(length, ANY_LENGTH)
    elif isinstance(kind, inspect.BytesType):
        length = max(length, ANY_LENGTH)
    message = message_of(kind)
    return _Field(name, _name(message) if message else ros or _PRIMITIVES[type(kind)], length, message)


_PRIMITIVES: dict[type[inspect.Type], str] = {
    inspect.FloatType: "float64",
    inspect.IntType: "int32",
    inspect.StrType: "string",
    inspect.BoolType: "bool",
    inspect.BytesType: "uint8",
}
