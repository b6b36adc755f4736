"""Conversion between messages as dicts, in the form of rosbridge's JSON, and the objects of ``rosbags``.

=============  ======================================  ================================================================
ROS            dict that is read                       dict that is returned
=============  ======================================  ================================================================
time           ``sec``, ``nanosec``, or as in ROS 1    ``sec``, ``nanosec`` in ROS 2, ``secs``, ``nsecs`` in ROS 1
uint8[]        bytes, base64 or a list                 bytes
numbers[]      a list or an array; null is NaN         an array, in the byte order of the sender
a field        its zero if it is left out or null      always there
=============  ======================================  ================================================================

As JSON, NaN and infinity are null and bytes are base64, as docs/protocol.md says.

A service is two messages and, in its hash, an event; an action is three services and messages around its own three
(ROS 2 design, "Actions" and REP-2016).
"""

import base64
import binascii
from collections.abc import Callable, Mapping
from typing import Any, Final, Protocol

import numpy as np

from ppaas.errors import MalformedMessage

# -- message types that services and actions of ROS 2 consist of -------------------------------------------------------

Fields = tuple[list[Any], list[Any]]
"""Constants and fields of a message, as ``rosbags`` describes them."""

Parse = Callable[[str, str], dict[str, Fields]]
"""Called with the text of a message and its name; returns its description by that name."""

BASE, NAME, SEQUENCE = 1, 2, 4
"""Kinds of fields in the descriptions of ``rosbags``: a number or text, a message, a list."""

_UUID: Any = ("goal_id", (NAME, "unique_identifier_msgs/msg/UUID"))
_TIME: Any = ("stamp", (NAME, "builtin_interfaces/msg/Time"))


def parsed(definitions: Mapping[str, str], parse: Parse) -> tuple[dict[str, Fields], dict[str, Fields]]:
    """Return the messages of definitions, and the services of them.

    Parameters
    ----------
    definitions : mapping of str to str
        Text of each definition by its full name, such as ``nav2_msgs/action/Wait``.
    parse : callable
        Parser of messages.

    Returns
    -------
    messages : dict
        Messages by full name, also of services and actions (``nav2_msgs/action/Wait_Goal``).
    services : dict
        Services by full name, also of actions (``nav2_msgs/action/Wait_SendGoal``), as the types whose
        hashes ROS 2 computes: request, response and event.
    """
    messages: dict[str, Fields] = {}
    services: dict[str, Fields] = {}
    for name, text in definitions.items():
        kind = name.split("/")[1]
        parts = _parts(name, text, parse)
        if kind == "msg":
            messages[name] = parts[0]
        elif kind == "srv":
            services |= _service(name, parts[0], parts[1], messages)
        else:
            services |= _action(name, parts, messages)
    return messages, services


def _parts(name: str, text: str, parse: Parse) -> list[Fields]:
    package, kind, _ = name.split("/")
    sections = "\n".join(line.strip() for line in text.splitlines()).split("---")
    if len(sections) != {"msg": 1, "srv": 2, "action": 3}[kind]:
        raise MalformedMessage(f"the definition of {name!r} has {len(sections)} parts")
    placeholder = f"{package}/msg/Part"
    return [parse(section.strip(), placeholder)[placeholder] for section in sections]


def _service(name: str, request: Fields, response: Fields, messages: dict[str, Fields]) -> dict[str, Fields]:
    messages[f"{name}_Request"], messages[f"{name}_Response"] = request, response
    event = [
        ("info", (NAME, "service_msgs/msg/ServiceEventInfo")),
        ("request", (SEQUENCE, ((NAME, f"{name}_Request"), 1))),
        ("response", (SEQUENCE, ((NAME, f"{name}_Response"), 1))),
    ]
    fields = [(f"{part.lower()}_message", (NAME, f"{name}_{part}")) for part in ("Request", "Response", "Event")]
    return {f"{name}_Event": ([], event), name: ([], fields)}


def _action(name: str, parts: list[Fields], messages: dict[str, Fields]) -> dict[str, Fields]:
    for part, fields in zip(("Goal", "Result", "Feedback"), parts, strict=True):
        messages[f"{name}_{part}"] = fields
    messages[f"{name}_FeedbackMessage"] = ([], [_UUID, ("feedback", (NAME, f"{name}_Feedback"))])
    send: Fields = ([], [_UUID, ("goal", (NAME, f"{name}_Goal"))])
    accepted: Fields = ([], [("accepted", (BASE, ("bool", 0))), _TIME])
    result: Fields = ([], [("status", (BASE, ("int8", 0))), ("result", (NAME, f"{name}_Result"))])
    sent = _service(f"{name}_SendGoal", send, accepted, messages)
    return sent | _service(f"{name}_GetResult", ([], [_UUID]), result, messages)


# -- conversion between messages as dicts and the objects of ``rosbags`` -----------------------------------------------

To = Callable[[Any], Any]
"""Called with a value of an object; returns the value of a dict."""

From = Callable[[Any, str], Any]
"""Called with a value of a dict and its place in the message; returns the value of an object."""

EMPTY: Final = "structure_needs_at_least_one_member"
"""Field that ``rosbags`` adds to messages without fields."""

_TIMES: Final = {"builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"}
_BYTES: Final = {"uint8", "byte", "char"}
_DTYPES: Final = {
    "bool": "?", "byte": "u1", "char": "u1", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4",
    "uint32": "u4", "int64": "i8", "uint64": "u8", "float32": "f4", "float64": "f8",
}  # fmt: skip


class TypeStore(Protocol):
    """The part of ``rosbags.typesys.store.Typestore`` that is used here."""

    types: dict[str, Any]
    fielddefs: dict[str, Any]


class TypeStoreConverter:
    """Converter of the messages of a type store.

    Parameters
    ----------
    store : TypeStore
        The types.
    ros1 : bool
        Whether times are spelled as in ROS 1.
    """

    def __init__(self, store: TypeStore, *, ros1: bool) -> None:
        self._store = store
        self._times = {"sec": "secs", "nanosec": "nsecs"} if ros1 else {}
        self._to: dict[str, To] = {}
        self._from: dict[str, From] = {}

    def to_dict(self, name: str, message: object) -> dict[str, Any]:
        """Return a message of a full type name as a dict."""
        converted: dict[str, Any] = self._to_message(name)(message)
        return converted

    def from_dict(self, name: str, values: object) -> object:
        """Return a dict as the object of a message.

        Raises
        ------
        MalformedMessage
            The dict is not a message of this type; the text names the place.
        """
        return self._from_message(name)(values, "$")

    # -- to dicts ------------------------------------------------------------------------------------------------------

    def _to_message(self, name: str) -> To:
        if name not in self._to:
            keys = self._times if name in _TIMES else {}
            described = [(field, keys.get(field, field), self._to_value(kind)) for field, kind in self._fields(name)]

            def convert(message: Any) -> dict[str, Any]:
                return {
                    key: getattr(message, field) if to is None else to(getattr(message, field))
                    for field, key, to in described
                }

            self._to[name] = convert
        return self._to[name]

    def _to_value(self, kind: tuple[int, Any]) -> To | None:
        node, detail = kind
        if node == BASE:
            return None
        if node == NAME:
            return self._to_message(detail)
        inner, _ = detail
        if inner[0] == NAME:
            item = self._to_message(inner[1])
            return lambda values: [item(value) for value in values]
        if inner[1][0] in _BYTES:
            return bytes
        return None

    def _fields(self, name: str) -> list[tuple[str, tuple[int, Any]]]:
        return [(field, kind) for field, kind in self._store.fielddefs[name][1] if field != EMPTY]

    # -- from dicts ----------------------------------------------------------------------------------------------------

    def _from_message(self, name: str) -> From:
        if name in self._from:
            return self._from[name]
        cls = self._store.types[name]
        read = {field: self._from_value(kind) for field, kind in self._fields(name)}
        spellings = {field: field for field in read} | _other_spellings(name, read)
        steps = [(field, f".{field}", one) for field, one in read.items()]

        def convert(values: Any, place: str) -> object:
            if type(values) is not dict and not isinstance(values, Mapping):  # the first is faster, and usual
                if values is None or (values == "now" and name in _TIMES):
                    values = {}
                else:
                    raise MalformedMessage(f"expected an object with the fields of {name} at `{place}`")
            if not values.keys() <= read.keys():
                values = _respelled(name, values, spellings, place)
            return cls(*[one(values.get(field), place + suffix) for field, suffix, one in steps])

        self._from[name] = convert
        return convert

    def _from_value(self, kind: tuple[int, Any]) -> From:
        node, detail = kind
        if node == BASE:
            return _scalar(detail[0])
        if node == NAME:
            return self._from_message(detail)
        inner, length = detail
        if inner[0] == BASE and inner[1][0] != "string":
            return _numbers(inner[1][0], length, exact=node != SEQUENCE)
        item = self._from_value(inner)
        return _items(item, length, exact=node != SEQUENCE)


def _other_spellings(name: str, fields: Mapping[str, From]) -> dict[str, str]:
    if name in _TIMES:
        return {"secs": "sec", "nsecs": "nanosec"}
    if name == "sensor_msgs/msg/CameraInfo":
        return {field.swapcase(): field for field in fields if len(field) == 1}
    # Messages of the cloud have the `seq` of ROS 1, which ROS 2 has not.
    return {"seq": "_seq"} if name == "std_msgs/msg/Header" and "seq" not in fields else {}


def _respelled(name: str, values: Mapping[str, Any], spellings: Mapping[str, str], place: str) -> dict[str, Any]:
    """Return values by the names of the fields of a message; raises ``MalformedMessage`` for an unknown name."""
    given: dict[str, Any] = {}
    for key, value in values.items():
        field = spellings.get(key)
        if field is None:
            fields = ", ".join(dict.fromkeys(field for field in spellings.values() if field[0] != "_")) or "none"
            raise MalformedMessage(f"{name} has no field {str(key)[:64]!r} at `{place}`; its fields are: {fields}")
        given[field] = value
    return given


def _read_text(value: Any, place: str) -> str:
    if value is None or isinstance(value, str):
        return value or ""
    raise MalformedMessage(f"expected text at `{place}`, got {type(value).__name__}")


def _read_bool(value: Any, place: str) -> bool:
    if value is None or isinstance(value, bool | int):
        return bool(value)
    raise MalformedMessage(f"expected true or false at `{place}`, got {type(value).__name__}")


def _read_float(value: Any, place: str) -> float:
    if type(value) is float:
        return value
    if value is None:
        return 0.0
    if isinstance(value, int | float):
        return float(value)
    raise MalformedMessage(f"expected a number at `{place}`, got {type(value).__name__}")


def _integers(kind: str) -> From:
    info = np.iinfo(_DTYPES[kind])
    low, high = int(info.min), int(info.max)

    def read(value: Any, place: str) -> int:
        if value is None:
            return 0
        if isinstance(value, int | float) and low <= value <= high and value == int(value):
            return int(value)
        raise MalformedMessage(f"expected a whole number from {low} to {high} at `{place}`")

    return read


def _scalar(kind: str) -> From:
    if kind == "string":
        return _read_text
    if kind == "bool":
        return _read_bool
    return _read_float if kind.startswith("float") else _integers(kind)


def _numbers(kind: str, length: int, *, exact: bool) -> From:
    dtype = np.dtype(_DTYPES[kind])

    def read(value: Any, place: str) -> np.ndarray[Any, Any]:
        try:
            if value is None:
                return np.zeros(length if exact else 0, dtype)
            if isinstance(value, str) and dtype == np.uint8:
                value = base64.b64decode(value)
            if isinstance(value, bytes | bytearray | memoryview) and dtype == np.uint8:
                array = np.frombuffer(value, np.uint8)
            else:
                array = np.asarray(value, dtype)
        except (binascii.Error, ValueError, TypeError, OverflowError) as error:
            raise MalformedMessage(f"no list of {kind} at `{place}`: {error}") from error
        if array.ndim != 1:
            raise MalformedMessage(f"expected a list of {kind} at `{place}`")
        _check_length(len(array), length, place, exact=exact)
        return array

    return read


def _items(item: From, length: int, *, exact: bool) -> From:
    def read(value: Any, place: str) -> list[Any]:
        if value is None:
            value = [None] * (length if exact else 0)
        if not isinstance(value, list | tuple):
            raise MalformedMessage(f"expected a list at `{place}`")
        _check_length(len(value), length, place, exact=exact)
        return [item(one, place) for one in value]

    return read


def _check_length(count: int, length: int, place: str, *, exact: bool) -> None:
    if (count != length) if exact else (length and count > length):
        raise MalformedMessage(f"expected {length} values at `{place}`{'' if exact else ' at most'}, got {count}")


SHORT = (8, 6)
"""Decimals to which numbers of 32 bits are rounded where that does not change them, the fewest last."""


def to_json_value(value: object) -> object:
    """Return an array as a list, for encoders of JSON; numbers of 32 bits have as few digits as say the same.

    Raises
    ------
    TypeError
        The value is not an array.
    """
    if not isinstance(value, np.ndarray):
        raise TypeError(f"not a value of a message: {type(value).__name__}")
    if value.dtype.kind == "f" and value.dtype.itemsize == 4:
        with np.errstate(all="ignore"):  # overflows, and NaN that signal
            shortest = value.astype(np.float64)
            for decimals in SHORT:
                short = shortest.round(decimals)
                shortest = np.where(short.astype(np.float32) == value, short, shortest)
        return shortest.tolist()
    return value.tolist()
