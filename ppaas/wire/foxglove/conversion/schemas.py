"""Schemas of channels: of protobuf, of ROS 2, and of JSON."""

import base64
from typing import Any, Final

import msgspec
from msgspec import inspect

from ppaas.messages.base.message import Message, message_of, plain, struct_of
from ppaas.messages.registry import type_name
from ppaas.wire.foxglove.answers import Schema
from ppaas.wire.names import ros2_type
from ppaas.wire.ros.own_types import types_with

_NUMBERS: Final[dict[type[inspect.Type], str]] = {
    inspect.FloatType: "number",
    inspect.IntType: "integer",
    inspect.BoolType: "boolean",
}


def protobuf(kind: Any) -> Schema:
    """Return the schema of a type of ``foxglove-sdk``."""
    schema = kind.get_schema()
    return Schema("protobuf", schema.name, schema.encoding, base64.b64encode(schema.data).decode())


def cdr(kind: str) -> Schema:
    """Return the schema of a type of ROS 2 or of the cloud, given as spelled in ROS 1; raises as `types_with`."""
    return Schema("cdr", ros2_type(kind, "msg"), "ros2msg", types_with(kind).definition(kind))


def json_schema(name: str, message: type[Message] | None) -> Schema:
    """Return the schema of messages as JSON; without a type, the schema of any object."""
    described = {"type": "object"} if message is None else described_object(message)
    return Schema("json", name, "jsonschema", msgspec.json.encode(described).decode())


def json_of(message: type[Message]) -> Schema:
    """Return the schema of a message type as JSON, with its name."""
    return json_schema(type_name(message), message)


def described_object(message: type[Message]) -> dict[str, Any]:
    """Return the JSON schema of a message, without references, which Foxglove does not follow."""
    fields = {field.encode_name: _described(field.type) for field in struct_of(message).fields}
    return {"type": "object", "properties": fields}


def _described(kind: inspect.Type) -> dict[str, Any]:
    bare, _, _ = plain(kind)
    inner = message_of(bare)
    if inner is not None:
        return described_object(inner)
    if isinstance(bare, inspect.ListType):
        return {"type": "array", "items": _described(bare.item_type)}
    if isinstance(bare, inspect.BytesType):
        return {"type": "string", "contentEncoding": "base64"}
    return {"type": _NUMBERS.get(type(bare), "string")}
