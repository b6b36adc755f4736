"""Files of zones as JSON, in any encoding of Unicode, and with numbers that are none."""

import json
from typing import Any

import msgspec

from ppaas.errors import InvalidZones
from ppaas.zones.foreign import foreign_text
from ppaas.zones.notes import Notes


def decoded(text: str | bytes, notes: Notes) -> dict[str, Any]:
    """Return the object in a file of JSON, with or without a byte-order mark.

    ``NaN`` and ``Infinity``, which are not JSON and which pandas and Python write for what is missing, are null.

    Raises
    ------
    InvalidZones
        It is not JSON, or not an object; the text says what it is, where that is known.
    """
    try:
        plain = text.decode(json.detect_encoding(text)) if isinstance(text, bytes) else text
    except UnicodeError as error:
        raise InvalidZones(f"zones are not valid JSON: {error!s:.300}; save the file in UTF-8") from error
    plain = plain.removeprefix("\ufeff")
    try:
        tree = msgspec.json.decode(plain)
    except (msgspec.DecodeError, UnicodeError) as error:
        tree = _without_numbers_that_are_none(plain, error)
        notes.add("NaN and infinite numbers are not JSON, and were read as null")
    except RecursionError as error:
        raise InvalidZones("zones are not valid: they are nested too deeply") from error
    if not isinstance(tree, dict):
        raise InvalidZones(f"zones must be a FeatureCollection of GeoJSON: Expected `object`, got `{type_of(tree)}`")
    return tree


def type_of(value: Any) -> str:
    """Return the name of the type of a value of JSON."""
    kinds = {list: "array", str: "str", int: "int", float: "float", bool: "bool", type(None): "null"}
    return kinds.get(type(value), type(value).__name__)


def _without_numbers_that_are_none(text: str, error: Exception) -> Any:
    """Return what a text is but for its numbers that are none, all of which are read as null."""
    found: list[str] = []
    try:
        tree = json.loads(text, parse_constant=found.append)
        json.dumps(tree, ensure_ascii=False).encode()  # halves of surrogate pairs are not text
    except (ValueError, RecursionError):
        found.clear()
    if not found:
        empty = "" if text.strip() else "the file is empty"
        raise InvalidZones(foreign_text(text) or f"zones are not valid JSON: {empty or error!s:.300}") from error
    return tree
