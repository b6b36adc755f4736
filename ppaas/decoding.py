"""Decoding of typed values, from any thread.

msgspec describes a type, and each class in it, when the type is first used. Here one thread at a time does so, and a
type is used once its description is complete.
"""

import threading
from typing import Any, TypeVar, overload

import msgspec

T = TypeVar("T")

_describing = threading.Lock()
_described: set[Any] = set()


def describe(kind: Any) -> None:
    """Have msgspec describe a type, unless it has."""
    if kind not in _described:
        with _describing:
            msgspec.json.Decoder(kind)
            _described.add(kind)


@overload
def from_json(data: bytes | bytearray | memoryview | msgspec.Raw | str, kind: type[T], *, strict: bool = ...) -> T: ...
@overload
def from_json(data: bytes | bytearray | memoryview | msgspec.Raw | str, kind: Any, *, strict: bool = ...) -> Any: ...
def from_json(data: Any, kind: Any, *, strict: bool = True) -> Any:
    """Decode JSON as a type; see ``msgspec.json.decode`` for arguments and errors."""
    describe(kind)
    return msgspec.json.decode(data, type=kind, strict=strict)


@overload
def from_msgpack(data: bytes | bytearray | memoryview, kind: type[T], *, strict: bool = ...) -> T: ...
@overload
def from_msgpack(data: bytes | bytearray | memoryview, kind: Any, *, strict: bool = ...) -> Any: ...
def from_msgpack(data: Any, kind: Any, *, strict: bool = True) -> Any:
    """Decode MessagePack as a type; see ``msgspec.msgpack.decode`` for arguments and errors."""
    describe(kind)
    return msgspec.msgpack.decode(data, type=kind, strict=strict)


@overload
def converted(value: Any, kind: type[T], *, strict: bool = ...) -> T: ...
@overload
def converted(value: Any, kind: Any, *, strict: bool = ...) -> Any: ...
def converted(value: Any, kind: Any, *, strict: bool = True) -> Any:
    """Return decoded JSON or YAML as a type; see ``msgspec.convert`` for arguments and errors."""
    describe(kind)
    return msgspec.convert(value, kind, strict=strict)
