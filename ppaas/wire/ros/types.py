"""Types of one release of ROS, and the coding of their messages."""

import hashlib
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import ModuleType
from typing import Any, Final

import msgspec

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, UnknownType
from ppaas.wire.ros.definitions import DEFINITIONS
from ppaas.wire.ros.values import NAME, SEQUENCE, TypeStoreConverter, parsed, to_json_value

ROS_1: Final = "noetic"
"""Release with the messages of ROS 1."""

RELEASES: Final = tuple(DEFINITIONS)
"""Releases whose types are known."""

NO_HASH: Final = "TypeHashNotSupported"
"""Text of rmw_zenoh in place of the hash of a type in releases before Iron."""

MAX_MESSAGE = 64 << 20
"""Largest message that is read [bytes]: a map of 8000 × 8000 cells."""

_encoder = msgspec.json.Encoder(enc_hook=to_json_value)
_decoder = msgspec.json.Decoder()


@dataclass(frozen=True, slots=True)
class Field:
    """Field of a message.

    Parameters
    ----------
    name : str
        Its name.
    type : str
        A type of numbers, ``bool``, ``string``, or the full name of a message.
    length : int, optional
        Length of an array, 0 for a list of any length; None for a single value.
    bound : int
        Largest length of a list; 0 for none.
    text_bound : int
        Largest length of a text; 0 for none.
    """

    name: str
    type: str
    length: int | None = None
    bound: int = 0
    text_bound: int = 0


class RosTypes:
    """Types of one release.

    Names of types may be spelled as in ROS 1 (``nav_msgs/Path``) or ROS 2 (``nav_msgs/msg/Path``).

    Parameters
    ----------
    release : str
        ``noetic``, ``humble``, ``jazzy`` or ``kilted``.
    ros2_times : bool
        Whether times of ROS 1 are read as in ROS 2: ``sec`` and ``nanosec`` in place of ``secs`` and ``nsecs``.

    Raises
    ------
    InvalidInput
        The release is not known, or ``rosbags`` is not installed; the text says how to install it.
    """

    def __init__(self, release: str, *, ros2_times: bool = False) -> None:
        if release not in DEFINITIONS:
            raise InvalidInput(f"unknown release of ROS {release!r}; known: {', '.join(RELEASES)}")
        self.release = release
        self.ros1 = release == ROS_1
        self._hashes: dict[str, str] = {}
        rosbags, errors = _rosbags()
        self._errors = errors
        self._store: Any = rosbags.get_typestore(rosbags.Stores(f"{'ros1' if self.ros1 else 'ros2'}_{release}"))
        self._store.max_sequence_length = MAX_MESSAGE
        messages, self._services = parsed(DEFINITIONS[release], rosbags.get_types_from_msg)
        self._store.register({name: fields for name, fields in messages.items() if name not in self._store.fielddefs})
        if not self.ros1:
            _spell_char_as_uint8(self._store.fielddefs)
            self._store.fielddefs |= self._services
        self._converter = TypeStoreConverter(self._store, ros1=self.ros1 and not ros2_times)

    def __contains__(self, name: str) -> bool:
        return self._full(name) in self._store.types

    def knows(self, name: str) -> bool:
        """Return whether a message or a service is known."""
        return name in self or name in self._services

    def learn(self, name: str, text: str) -> None:
        """Add a message that the release lacks, and those in it.

        Parameters
        ----------
        name : str
            Name of the type.
        text : str
            The definitions of it and of the messages in it, as ``definition`` returns them; known messages stay.
        """
        described = _rosbags()[0].get_types_from_msg(text, self._full(name))
        self._store.register({known: fields for known, fields in described.items() if known not in self._store.types})

    def encode(self, name: str, values: Mapping[str, Any]) -> bytes:
        """Return a message as bytes: CDR, little endian and with its header of four bytes, or ROS 1's serialization.

        Raises
        ------
        UnknownType
            The type is unknown.
        MalformedMessage
            The dict is not a message of this type; the text names the place.
        """
        full = self._known(name)
        try:
            message = self._converter.from_dict(full, values)
            if self.ros1:
                return bytes(self._store.serialize_ros1(message, full))
            return bytes(self._store.serialize_cdr(message, full, little_endian=True))
        except (struct.error, ValueError, OverflowError, MalformedMessage) as error:
            raise MalformedMessage(f"not a {name}: {error}") from error

    def decode(self, name: str, data: bytes | memoryview) -> dict[str, Any]:
        """Return a message as a dict.

        Raises
        ------
        UnknownType
            The type is unknown.
        MessageTooLarge
            The message has more than `MAX_MESSAGE` bytes.
        MalformedMessage
            The bytes are not a message of this type.
        """
        full = self._known(name)
        if len(data) > MAX_MESSAGE:
            raise MessageTooLarge(f"a message of {len(data)} bytes; at most {MAX_MESSAGE} are read")
        try:
            read = self._store.deserialize_ros1 if self.ros1 else self._store.deserialize_cdr
            return self._converter.to_dict(full, read(data, full))
        except self._errors as error:
            raise MalformedMessage(f"not a {name}: {error}") from error

    def encode_json(self, name: str, text: bytes | msgspec.Raw) -> bytes:
        """Return a message given as JSON of rosbridge as bytes; raises as ``encode``."""
        try:
            return self.encode(name, _decoder.decode(text))
        except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
            raise MalformedMessage(f"not a {name}: not JSON: {error}") from error

    def decode_json(self, name: str, data: bytes | memoryview) -> bytes:
        """Return a message as JSON of rosbridge; raises as ``decode``."""
        return to_json(self.decode(name, data))

    def type_hash(self, name: str) -> str:
        """Return the hash of a message or a service of ROS 2, ``RIHS01_`` and 64 digits (REP-2016).

        Humble has no hashes; its rmw_zenoh writes `NO_HASH` in their place.

        Raises
        ------
        UnknownType
            The type is unknown.
        """
        full = name if name in self._services else self._known(name)
        if self.release == "humble":
            return NO_HASH
        if full not in self._hashes:
            self._hashes[full] = str(self._store.hash_rihs01(full))
        return self._hashes[full]

    def md5(self, name: str) -> str:
        """Return the sum by which nodes of ROS 1 compare the definitions of a message or a service.

        Raises
        ------
        UnknownType
            The type is unknown.
        """
        if name in self._services:
            text = "".join(self._text(f"{name}_{part}") for part in ("Request", "Response"))
            return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()
        return str(self._store.generate_msgdef(self._known(name), 1)[1])

    def definition(self, name: str) -> str:
        """Return the definition of a message and of those in it, as recordings and ROS 1 contain them.

        Raises
        ------
        UnknownType
            The type is unknown.
        """
        return str(self._store.generate_msgdef(self._known(name), 1 if self.ros1 else 2)[0])

    def fields(self, name: str) -> tuple[Field, ...]:
        """Return the fields of a message, in order.

        Raises
        ------
        UnknownType
            The type is unknown.
        """
        return tuple(map(_field, self._store.fielddefs[self._known(name)][1]))

    def _text(self, name: str) -> str:
        """Return the text of which ROS 1 computes the sum of a message: messages in it are their sums."""
        constants, fields = self._store.fielddefs[name]
        lines = [f"{kind} {field}={value}" for field, kind, value in constants]
        for field, (node, detail) in fields:
            if field.startswith("structure_needs"):
                continue
            inner = detail[0][1] if node > NAME else detail
            lines.append(f"{inner[0] if isinstance(inner, tuple) else self.md5(inner)} {field}")
        return "\n".join(lines)

    def _known(self, name: str) -> str:
        full = self._full(name)
        if full not in self._store.types:
            raise UnknownType(f"type {name[:64]!r} is unknown in ROS {self.release}")
        return full

    @staticmethod
    def _full(name: str) -> str:
        package, _, rest = name.partition("/")
        return name if "/" in rest else f"{package}/msg/{rest}"


def _field(described: tuple[str, tuple[int, Any]]) -> Field:
    name, (node, detail) = described
    length, bound = None, 0
    if node > NAME:
        (_, inner), count = detail
        length, bound = (0, count) if node == SEQUENCE else (count, 0)
    else:
        inner = detail
    if isinstance(inner, str):
        return Field(name, inner, length, bound)
    return Field(name, inner[0], length, bound, inner[1])


def to_json(values: Mapping[str, Any]) -> bytes:
    """Return a message given as a dict as JSON of rosbridge."""
    return _encoder.encode(values)


@cache
def ros_types(release: str, *, ros2_times: bool = False) -> RosTypes:
    """Return the types of a release; they are made once. Arguments and errors are the same as for `RosTypes`."""
    return RosTypes(release, ros2_times=ros2_times)


def _rosbags() -> tuple[ModuleType, tuple[type[Exception], ...]]:
    try:
        from rosbags import typesys  # noqa: PLC0415 - of the extras ros2 and bags
        from rosbags.serde import SerdeError  # noqa: PLC0415
    except ImportError as error:
        raise InvalidInput(f"messages of ROS need the extra ros2: {install_hint('ros2')}") from error
    return typesys, (SerdeError, struct.error, ValueError, IndexError, OverflowError)


def _spell_char_as_uint8(described: dict[str, Any]) -> None:
    """Replace ``char`` by ``uint8``, which it is in ROS 2; ``rosbags`` 0.11 has another number for it in hashes."""

    def spelled(kind: Any) -> Any:
        return tuple(spelled(one) for one in kind) if isinstance(kind, tuple) else "uint8" if kind == "char" else kind

    for name, (constants, fields) in list(described.items()):
        if any("char" in repr(kind) for _, kind in fields):
            described[name] = (constants, [(field, spelled(kind)) for field, kind in fields])
