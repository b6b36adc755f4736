"""Binary parts of messages: a field ``"name*"`` has the uuid of a part, which is sent as a separate binary frame.

The frame is 32 ASCII characters of the uuid, then the bytes. Parts may come before their message. What is incomplete
after `TIMEOUT` is dropped.

Source: ``rce/comm/assembler.py``.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any
from uuid import uuid4

from ppaas.clock import Clock, monotonic
from ppaas.errors import MalformedMessage, MessageTooLarge, QuotaExceeded
from ppaas.messages.base.spelling import read_json

TIMEOUT = 60.0
"""Time after the last part at which an incomplete message, or a part without a message, is dropped [s]."""

UUID_LENGTH = 32
"""Length of a uuid [hexadecimal digits]."""

MAX_TEXT = 4 << 20
"""Largest text of a message [bytes]: a map of a million cells, or more; what is larger goes as a binary part."""

MAX_OBJECTS = 20_000
"""Largest number of objects and lists in a message."""

MAX_WAITING = 64
"""Largest number of incomplete messages, and of parts without a message; beyond it, the oldest is dropped."""

MAX_PARTS = 256
"""Largest number of parts of a message."""

MAX_BYTES = 32 << 20
"""Largest size of all parts that wait for their message, or for others of it [bytes]."""

MAX_DEPTH = 64
"""Largest number of objects and lists within each other in a message."""

MARK = "*"
"""Last character of the name of a field whose value is the uuid of a part."""

_UUID = re.compile(r"[0-9a-fA-F]{32}", re.ASCII)

_Place = Callable[[bytes], None]
"""Called with the bytes of a part; puts them into the message."""


@dataclass(slots=True)
class _Incomplete:
    message: dict[str, Any]
    places: dict[str, _Place]
    newest: float
    size: int = 0
    """Size of the parts in place [bytes]."""


@dataclass(slots=True)
class _Early:
    data: bytes
    received: float


@dataclass(slots=True)
class PartAssembler:
    """Messages of one robot, with their binary parts.

    Parameters
    ----------
    clock : callable
        Returns monotonic time [s].
    """

    clock: Clock = monotonic
    _incomplete: list[_Incomplete] = field(default_factory=list)
    _early: dict[str, _Early] = field(default_factory=dict)

    @property
    def waiting(self) -> int:
        """Number of incomplete messages, and of parts without a message."""
        return len(self._incomplete) + len(self._early)

    def take_text(self, text: str) -> dict[str, Any] | None:
        """Take a text frame; return the message, or None while it lacks a part.

        Raises
        ------
        MalformedMessage
            The text is not a JSON object, is nested too deeply, or a reference is not a uuid.
        MessageTooLarge
            The text is too large.
        QuotaExceeded
            It has too many parts.
        """
        self._expire()
        data = text.encode(errors="replace")
        if len(data) > MAX_TEXT or data.count(b"{") + data.count(b"[") > MAX_OBJECTS:
            raise MessageTooLarge(
                f"the text of a message may have {MAX_TEXT >> 20} MiB and {MAX_OBJECTS} objects and lists: send more "
                "as a binary part"
            )
        message = read_json(data, MAX_TEXT)
        if not isinstance(message, dict):
            raise MalformedMessage("A message has to be a JSON object.")
        places = dict(_places(message, MAX_DEPTH))
        if len(places) > MAX_PARTS:
            raise QuotaExceeded(f"a message may have at most {MAX_PARTS} binary parts")
        entry = _Incomplete(message, places, self.clock())
        for uuid in [uuid for uuid in places if uuid in self._early]:
            self._put(entry, uuid, self._early.pop(uuid).data)
        if not places:
            return message
        self._incomplete = [*self._incomplete, entry][-MAX_WAITING:]
        self._check_size()
        return None

    def take_binary(self, frame: bytes) -> dict[str, Any] | None:
        """Take a binary frame; return the message that it completes, if any.

        Raises
        ------
        MalformedMessage
            The frame does not begin with a uuid.
        QuotaExceeded
            The parts that wait are too large.
        """
        self._expire()
        uuid = _checked(frame[:UUID_LENGTH].decode("latin-1"))
        data = frame[UUID_LENGTH:]
        for entry in self._incomplete:
            if uuid in entry.places:
                self._put(entry, uuid, data)
                if entry.places:
                    self._check_size()
                    return None
                self._incomplete.remove(entry)
                return entry.message
        self._early[uuid] = _Early(data, self.clock())
        if len(self._early) > MAX_WAITING:
            del self._early[next(iter(self._early))]
        self._check_size()
        return None

    def _put(self, entry: _Incomplete, uuid: str, data: bytes) -> None:
        entry.places.pop(uuid)(data)
        entry.size += len(data)
        entry.newest = self.clock()

    def _check_size(self) -> None:
        """Drop all that waits if it is too large: no part of it could be completed by a robot that sends so much."""
        size = sum(entry.size for entry in self._incomplete) + sum(len(early.data) for early in self._early.values())
        if size > MAX_BYTES:
            self._incomplete, self._early = [], {}
            raise QuotaExceeded(
                f"the binary parts that wait for their messages have more than {MAX_BYTES >> 20} MiB: they are dropped"
            )

    def _expire(self) -> None:
        oldest = self.clock() - TIMEOUT
        self._incomplete = [entry for entry in self._incomplete if entry.newest >= oldest]
        self._early = {uuid: early for uuid, early in self._early.items() if early.received >= oldest}


def _checked(uuid: object) -> str:
    if not isinstance(uuid, str) or not _UUID.fullmatch(uuid):
        raise MalformedMessage(f"a binary part has a uuid of {UUID_LENGTH} hexadecimal digits, not {str(uuid)[:40]!r}")
    return uuid


def _places(value: object, depth: int) -> Iterator[tuple[str, _Place]]:
    """Yield the references in a value with the places of their parts, and remove the references."""
    if depth < 0:
        raise MalformedMessage(f"a message may have at most {MAX_DEPTH} levels")
    if isinstance(value, list):
        for item in value:
            if isinstance(item, dict | list):
                yield from _places(item, depth - 1)
    elif isinstance(value, dict):
        for key in tuple(value):
            if key.endswith(MARK):
                yield from _referred(value, key)
            else:
                yield from _places(value[key], depth - 1)


def _referred(fields: dict[str, Any], key: str) -> Iterator[tuple[str, _Place]]:
    reference, name = fields.pop(key), key.removesuffix(MARK)
    if isinstance(reference, list):
        items: list[Any] = [b""] * len(reference)
        fields[name] = items
        for number, uuid in enumerate(reference):
            yield _checked(uuid), _setter(items, number)
    else:
        yield _checked(reference), _setter(fields, name)


def _setter(container: Any, key: str | int) -> _Place:
    def put(data: bytes) -> None:
        container[key] = data

    return put


def with_references(value: Any) -> tuple[Any, list[bytes]]:
    """Return a value with references in place of its bytes, and the binary frames of these parts.

    Parameters
    ----------
    value : dict, list or value of JSON
        Value; fields, and items of lists that consist of them, may be bytes.
    """
    frames: list[bytes] = []
    return _referring(value, frames), frames


def _referring(value: Any, frames: list[bytes]) -> Any:
    if isinstance(value, list):
        return [_referring(item, frames) for item in value] if any(isinstance(i, dict | list) for i in value) else value
    if not isinstance(value, dict):
        return value
    fields: dict[str, Any] = {}
    for key, item in value.items():
        if isinstance(item, bytes):
            fields[f"{key}{MARK}"] = _frame(item, frames)
        elif isinstance(item, list) and item and all(isinstance(part, bytes) for part in item):
            fields[f"{key}{MARK}"] = [_frame(part, frames) for part in item]
        else:
            fields[key] = _referring(item, frames)
    return fields


def _frame(data: bytes, frames: list[bytes]) -> str:
    uuid = uuid4().hex
    frames.append(uuid.encode() + data)
    return uuid
