"""Rules of zones from the properties of features, also of those that went through the tables of a GIS."""

import re
from typing import Any, get_args

import msgspec

from ppaas.decoding import converted
from ppaas.errors import InvalidZones
from ppaas.zones.notes import Notes
from ppaas.zones.zone import KINDS, AnyRule

_SWITCHES = {"one_way", "strict"}
"""Properties that are true or false."""

_WORDS = {"yes": True, "y": True, "t": True, "no": False, "n": False, "f": False}
"""Switches in words, as OpenStreetMap and PostgreSQL have them."""

_NAMES = {"kind", *(field.encode_name for rule in get_args(AnyRule) for field in msgspec.structs.fields(rule))}
"""Names of properties."""

_PATTERN = re.compile(r"`str` matching regex '.*?'(?= - at|$)")
"""The pattern of a time of day, in the words of msgspec."""


def rule_of(given: dict[str, Any], notes: Notes) -> AnyRule:
    """Return the rule of properties; what tables make of values is read as what it was, with a note.

    A property whose text is empty has no value, since the cells of a table that are not used are such texts.

    Raises
    ------
    InvalidZones
        A property is missing, unknown or wrong; the text says which.
    """
    used = {key: value for key, value in given.items() if key == "name" or not _is_blank(value)}
    named = {_name_of(key, used): value for key, value in used.items()}
    rule: AnyRule
    try:
        rule = converted(named, AnyRule)
        if named.keys() == used.keys():
            return rule
    except msgspec.ValidationError as wrong:
        values = {key: _as_it_was(key, value) for key, value in named.items()}
        known = {key: value for key, value in values.items() if value is not None}
        try:
            rule = converted(known, AnyRule, strict=False)
        except msgspec.ValidationError:
            raise InvalidZones(_in_words(str(wrong))) from None
    notes.add("properties of a table are read as what they were: whole floats as integers, text as values", rule.name)
    return rule


def _name_of(key: str, given: dict[str, Any]) -> str:
    """Return the name of a property, also of a column in capitals, as dBase and KML have them."""
    lower = key.lower()
    return lower if lower in _NAMES and lower not in given else key


def _is_blank(value: Any) -> bool:
    return isinstance(value, str) and not value.strip()


def _as_it_was(key: str, value: Any) -> Any:
    """Return a value as it was before a table had it; None for none."""
    if key == "times" and isinstance(value, str):
        try:
            return msgspec.json.decode(value)
        except msgspec.DecodeError as error:
            raise InvalidZones(f"'times' is text that is not valid JSON: {error!s:.100}") from error
    if key in _SWITCHES and isinstance(value, str):
        return _WORDS.get(value.strip().lower(), value)
    whole = int(value) if isinstance(value, float) and value.is_integer() else value
    is_number = isinstance(whole, int | float) and not isinstance(whole, bool)
    return str(whole) if key == "name" and is_number else whole


def _in_words(text: str) -> str:
    """Return an error of msgspec with what may be given."""
    text = _PATTERN.sub("a time of day such as '08:30' or '24:00'", text)
    if text.endswith("`$.kind`") or "field `kind`" in text:
        return f"{text}; its kind is one of {', '.join(KINDS)}"
    if "RFC3339" in text:
        return f"{text}; give a moment such as '2026-05-01T08:00:00'"
    return text
