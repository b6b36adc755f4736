"""Top-level keys of a YAML file, as yaml-cpp reads them for map_server and Nav2.

Only the first document counts, and of equal keys the first. Scalars are text. Merge keys and tags are not interpreted,
and nested contents are only walked through, so the work grows with the size of the file alone.

Sources: YAML 1.2.2, and yaml-cpp 0.7 (``scanner.cpp``, ``stream.cpp``, ``node_data.cpp``).
"""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

import yaml

from ppaas.errors import InvalidMap

Value = str | list["Value"] | dict[str, "Value"] | None
"""Value of a key: a scalar's text, a list, an empty dict in place of any mapping, or None for an empty value."""

_LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)
"""libyaml's scanner, which takes tabs as white space; PyYAML's own does not."""

MAX_BRACKETS = 100
MAX_DEPTH = 20
"""Largest number of brackets, and of levels of nesting: deeply nested brackets take a parser long."""

_NULLS = ("", "~", "null", "Null", "NULL")
_PLAIN = re.compile(r"[A-Za-z0-9][A-Za-z0-9_./-]*")

_LEADING_TABS = re.compile(r"^(?:[ \t]+(?=[\[\]{},#\r\n]|\Z)| *(?:-[ \t]+)+)", re.MULTILINE)
"""White space where yaml-cpp takes tabs but libyaml does not: before comments, brackets and line ends, after dashes."""

_ESCAPED = "utf-8-escaped"
_TO_PRIVATE = {0xDC00 + byte: 0xE000 + byte for byte in range(0x80, 0x100)}
_FROM_PRIVATE = {private: surrogate for surrogate, private in _TO_PRIVATE.items()}


@dataclass(frozen=True, slots=True)
class _Entry:
    """Value of a key, and where key and value are in the text."""

    value: Value
    key_start: int
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class _Document:
    entries: dict[str, _Entry]
    in_braces: bool


def read_keys(record: bytes) -> dict[str, Value] | None:
    """Return the top-level keys of a YAML file; None if its first document is not a mapping.

    Bytes that are not UTF-8 (or UTF-16, UTF-32) are read as Python reads such file names (PEP 383).

    Raises
    ------
    InvalidMap
        The file is not YAML, or it is nested too deeply.
    """
    text, encoding = _decode(record)
    document = _first_document(text)
    if document is None:
        return None
    keys = {key: entry.value for key, entry in document.entries.items()}
    if encoding == _ESCAPED:
        return {key: value.translate(_FROM_PRIVATE) if isinstance(value, str) else value for key, value in keys.items()}
    return keys


def with_key(record: bytes, key: str, value: str) -> bytes:
    """Return a YAML file with one top-level key set to a text; all other bytes stay as they are.

    Raises
    ------
    InvalidMap
        As ``read_keys``; or the first document is not a mapping with at least one key, or the key has another value.
    """
    text, encoding = _decode(record)
    document = _first_document(text)
    if document is None or not document.entries:
        raise InvalidMap("the map's YAML is not a map_server record: it must be a list of keys and values")
    scalar = value if _PLAIN.fullmatch(value) and value not in _NULLS else _quoted(value)
    entry = document.entries.get(key)
    if entry is None:
        first = min(each.key_start for each in document.entries.values())
        indent = first - max(text.rfind("\n", 0, first), text.rfind("\r", 0, first)) - 1
        end = ", " if document.in_braces else "\n" + " " * indent
        changed = f"{text[:first]}{key}: {scalar}{end}{text[first:]}"
    elif isinstance(entry.value, (str, type(None))):
        gap = " " if text[entry.start - 1 : entry.start] == ":" else ""
        changed = text[: entry.start] + gap + scalar + text[entry.end :]
    else:
        raise InvalidMap(f"the map's YAML is not a map_server record: `{key}` must be text")
    return _encode(changed, encoding)


def _quoted(value: str) -> str:
    text: str = yaml.safe_dump(value, default_style='"', allow_unicode=True, width=1 << 16)
    return text.rstrip("\n")


def _decode(record: bytes) -> tuple[str, str]:
    """Return the text and its encoding; other bytes than UTF-8 become characters of the private use area."""
    encoding = json.detect_encoding(record)
    try:
        return record.decode(encoding), encoding
    except UnicodeDecodeError as error:
        if not encoding.startswith("utf-8"):
            raise InvalidMap(f"the map's YAML cannot be read: it is not valid {encoding.upper()} text") from error
    return record.decode("utf-8", "surrogateescape").translate(_TO_PRIVATE), _ESCAPED


def _encode(text: str, encoding: str) -> bytes:
    if encoding == _ESCAPED:
        return text.translate(_FROM_PRIVATE).encode("utf-8", "surrogateescape")
    return text.encode(encoding)


def _first_document(text: str) -> _Document | None:
    """Return the entries of the first document if it is a mapping; nothing after it is read."""
    if text.count("[") + text.count("{") > MAX_BRACKETS:
        raise InvalidMap(f"the map's YAML cannot be read: it has more than {MAX_BRACKETS} brackets")
    spaced = _LEADING_TABS.sub(lambda found: found[0].replace("\t", " "), text)
    try:
        events = iter(yaml.parse(spaced, Loader=_LOADER))
        return _Reader(events).document()
    except yaml.YAMLError as error:
        raise InvalidMap(f"the map's YAML cannot be read: {_fault(error, text)}") from error


def _fault(error: yaml.YAMLError, text: str) -> str:
    mark = getattr(error, "problem_mark", None)
    if mark is None:
        return " ".join(str(error).split())
    lines = text.splitlines()
    advice = "; indent with spaces" if mark.line < len(lines) and "\t" in lines[mark.line] else ""
    return f"line {mark.line + 1}, column {mark.column + 1}: {getattr(error, 'problem', error)}{advice}"


class _Reader:
    """Reads the first document from the events of a parser."""

    def __init__(self, events: Iterator[yaml.Event]) -> None:
        self._events = events
        self._anchors: dict[str | None, Value] = {}

    def document(self) -> _Document | None:
        for event in self._events:
            if isinstance(event, yaml.MappingStartEvent):
                return _Document(self._entries(), in_braces=bool(event.flow_style))
            if not isinstance(event, (yaml.StreamStartEvent, yaml.DocumentStartEvent)):
                return None
        return None

    def _entries(self) -> dict[str, _Entry]:
        found: dict[str, _Entry] = {}
        while not isinstance(key := next(self._events), yaml.MappingEndEvent):
            name = self._value(key, MAX_DEPTH)
            event = next(self._events)
            entry = _Entry(self._value(event, MAX_DEPTH), _span(key)[0], *_span(event))
            if isinstance(name, str):
                found.setdefault(name, entry)
        return found

    def _value(self, event: yaml.Event, depth: int) -> Value:
        anchor = event.anchor if isinstance(event, yaml.NodeEvent) else None
        if isinstance(event, yaml.AliasEvent):
            return self._anchors.get(anchor)
        value: Value
        if isinstance(event, yaml.ScalarEvent):
            value = None if event.implicit[0] and event.value in _NULLS else event.value
        else:
            value = self._collection(event, depth)
        self._anchors[anchor] = value
        return value

    def _collection(self, start: yaml.Event, depth: int) -> Value:
        if not depth:
            raise InvalidMap(f"the map's YAML cannot be read: it is nested more than {MAX_DEPTH} deep")
        items: list[Value] = []
        while not isinstance(event := next(self._events), yaml.CollectionEndEvent):
            items.append(self._value(event, depth - 1))
        return items if isinstance(start, yaml.SequenceStartEvent) else {}


def _span(event: yaml.Event) -> tuple[int, int]:
    start, end = (0 if mark is None else mark.index for mark in (event.start_mark, event.end_mark))
    return start, end
