"""Fields of LIF, the Layout Interchange Format of the VDMA, and what a file has that they do not allow.

Versions 0.11, 1.0 and, by the names before it (`lif_names`), the drafts of 2.0. A field is known if one of them has it.
"""

import functools
import math
from collections.abc import Iterator, Mapping
from types import GenericAlias
from typing import Any, Literal, NamedTuple

import msgspec

from ppaas.decoding import converted
from ppaas.imports.graphs.formats.lif_names import DEEPEST
from ppaas.imports.graphs.model.gathered import GatheredNotes


class LifField(NamedTuple):
    """Field of an object.

    Parameters
    ----------
    kind : str
        ``text``, ``number``, ``truth``, ``any``, ``texts``, ``numbers``, an object by name, or a list of such:
        ``[node]``.
    required : bool
    choices : tuple of str
        Values that a text may have; any if empty.
    """

    kind: str
    required: bool = False
    choices: tuple[str, ...] = ()


_ROTATIONS = ("NONE", "CCW", "CW", "BOTH")
_TEXT, _NUMBER, _TRUTH = LifField("text"), LifField("number"), LifField("truth")
_KEY = LifField("text", required=True)
_X = LifField("number", required=True)

FIELDS: Mapping[str, Mapping[str, LifField]] = {
    "lif": {"metaInformation": LifField("meta", required=True), "layouts": LifField("[layout]", required=True)},
    "meta": {"projectIdentification": _KEY, "creator": _KEY, "exportTimestamp": _KEY, "lifVersion": _KEY},
    "layout": {
        "layoutId": _KEY, "layoutName": _TEXT, "layoutVersion": _KEY, "layoutLevelId": _TEXT,
        "layoutDescription": _TEXT, "nodes": LifField("[node]", required=True),
        "edges": LifField("[edge]", required=True), "stations": LifField("[station]", required=True),
    },
    "node": {
        "nodeId": _KEY, "nodeName": _TEXT, "nodeDescription": _TEXT, "mapId": _TEXT,
        "nodePosition": LifField("position", required=True),
        "vehicleTypeNodeProperties": LifField("[node of a vehicle]", required=True),
    },
    "position": {"x": _X, "y": _X, "theta": _NUMBER},
    "node of a vehicle": {
        "vehicleTypeId": _KEY, "theta": _NUMBER, "actions": LifField("[action]"), "loadRestriction": LifField("load"),
        "allowedDeviationXY": LifField("deviation"),
    },
    "action": {
        "actionType": _KEY, "actionDescription": _TEXT, "required": _TRUTH,
        "requirementType": LifField("text", choices=("REQUIRED", "CONDITIONAL", "OPTIONAL")),
        "blockingType": LifField("text", required=True, choices=("NONE", "SOFT", "SINGLE", "HARD")),
        "actionParameters": LifField("[parameter]"),
    },
    "parameter": {"key": _KEY, "value": LifField("any", required=True)},
    "edge": {
        "edgeId": _KEY, "edgeName": _TEXT, "edgeDescription": _TEXT, "startNodeId": _KEY, "endNodeId": _KEY,
        "vehicleTypeEdgeProperties": LifField("[edge of a vehicle]", required=True),
    },
    "edge of a vehicle": {
        "vehicleTypeId": _KEY, "vehicleOrientation": _NUMBER, "vehicleOrientations": LifField("numbers"),
        "orientationType": LifField("text", choices=("GLOBAL", "TANGENTIAL")), "rotationAllowed": _TRUTH,
        "reachOrientationBeforeEntering": _TRUTH,
        "rotationAtStartNodeAllowed": LifField("text", choices=_ROTATIONS),
        "rotationAtEndNodeAllowed": LifField("text", choices=_ROTATIONS),
        "maxSpeed": _NUMBER, "maxRotationSpeed": _NUMBER, "minHeight": _NUMBER, "maxHeight": _NUMBER,
        "loadRestriction": LifField("load"), "actions": LifField("[action]"), "trajectory": LifField("trajectory"),
        "reentryAllowed": _TRUTH, "allowedDeviationXY": LifField("deviation"), "corridor": LifField("corridor"),
        "physicalLineGuided": _TRUTH, "physicalLineGuidedProperty": LifField("line"),
    },
    "line": {"direction": _TEXT, "length": _NUMBER},
    "load": {
        "unloaded": LifField("truth", required=True), "loaded": LifField("truth", required=True),
        "loadSetNames": LifField("texts"),
    },
    "trajectory": {
        "degree": _NUMBER, "knotVector": LifField("numbers", required=True),
        "controlPoints": LifField("[control point]", required=True),
    },
    "control point": {"x": _X, "y": _X, "weight": _NUMBER},
    "deviation": {
        "a": _NUMBER, "b": _NUMBER, "aMinimum": _NUMBER, "bMinimum": _NUMBER, "aMaximum": _NUMBER, "bMaximum": _NUMBER,
        "theta": _NUMBER,
    },
    "corridor": {"maximumLeftWidth": _X, "maximumRightWidth": _X, "corridorReferencePoint": _TEXT},
    "station": {
        "stationId": _KEY, "interactionNodeIds": LifField("texts", required=True), "stationName": _TEXT,
        "stationDescription": _TEXT, "stationType": _TEXT, "stationHeight": _NUMBER,
        "stationPosition": LifField("position"),
    },
}  # fmt: skip
"""Fields by the name of their object."""

_MUST: Mapping[str, str] = {
    "text": "be a text", "number": "be a number", "truth": "be true or false", "texts": "have texts",
    "numbers": "have numbers",
}  # fmt: skip


def checked_fields(tree: Any, notes: GatheredNotes) -> Any:
    """Return a decoded file whose fields have no spaces around their names.

    Parameters
    ----------
    tree : object
        Decoded file.
    notes : GatheredNotes
        Takes what the format does not allow; nothing of it is refused for that.
    """
    faults = list(_faults(tree, "lif", ""))
    for part, text in faults:
        notes.translated(part, f"breaks the schema of LIF: {text}")
    names = {part.rpartition(".")[2] for part, _ in faults}
    return _without_spaces(tree, DEEPEST) if any(name != name.strip() for name in names) else tree


def _without_spaces(given: Any, depth: int) -> Any:
    if depth and isinstance(given, list):
        return [_without_spaces(each, depth - 1) for each in given]
    if not (depth and isinstance(given, dict)):
        return given
    names = sorted(given, key=lambda name: name == name.strip())
    return {name.strip(): _without_spaces(given[name], depth - 1) for name in names}


_TYPES: Mapping[str, Any] = {
    "text": str, "number": int | float, "truth": bool, "texts": list[str], "numbers": list[int | float],
    "any": Any,
}  # fmt: skip

_OUTER = ("lif", "[layout]", "layout")
"""Kinds that are walked, since one fault in a layout would have all of it checked in vain."""


@functools.cache
def _type_of(kind: str, choices: tuple[str, ...] = ()) -> Any:
    """Return the type of values of a kind, which msgspec checks many times faster than a walk that words the faults."""
    if choices:
        return Literal[choices]
    if kind.startswith("["):
        return GenericAlias(list, (_type_of(kind[1:-1]),))
    if kind in _TYPES:
        return _TYPES[kind]
    fields = sorted(FIELDS[kind].items(), key=lambda each: not each[1].required)
    types = [
        (name, _type_of(field.kind, field.choices), *(() if field.required else (None,))) for name, field in fields
    ]
    return msgspec.defstruct(kind.replace(" ", "_"), types, forbid_unknown_fields=True)


def _fits(given: Any, kind: str) -> bool:
    try:
        converted(given, _type_of(kind))
    except msgspec.ValidationError:
        return False
    return True


def _faults(given: Any, kind: str, part: str) -> Iterator[tuple[str, str]]:
    """Yield where a value breaks the format, and how."""
    if kind not in _OUTER and _fits(given, kind):
        return
    if kind.startswith("["):
        if not isinstance(given, list):
            yield part, "it must be a list"
            return
        for at, each in enumerate(given):
            yield from _faults(each, kind[1:-1], f"{part}[{at}]")
        return
    if kind not in FIELDS:
        yield part, f"it must {_MUST[kind]}"
    elif not isinstance(given, dict):
        yield part or "file", "it must be an object"
    else:
        yield from _faults_of_fields(given, kind, part)


def _faults_of_fields(given: Mapping[str, Any], kind: str, part: str) -> Iterator[tuple[str, str]]:
    for name, field in FIELDS[kind].items():
        where = f"{part}.{name}" if part else name
        if name in given:
            yield from _faults(given[name], field.kind, where)
            if field.choices and given[name] not in field.choices:
                yield where, f"it must be one of {', '.join(field.choices)}"
        elif field.required:
            yield where, "it is missing"
    for name in (name for name in given if name not in FIELDS[kind]):
        known = f"; {name.strip()} is" if name.strip() in FIELDS[kind] else ""
        yield (f"{part}.{name}" if part else name), f"no field of LIF{known}"


# -- values, read leniently --------------------------------------------------------------------------------------------


def objects(given: Any, name: str) -> list[tuple[int, Mapping[str, Any]]]:
    """Return the objects in a list of an object, each with its number; none if it has no such list."""
    found = field(given, name)
    return [(at, each) for at, each in enumerate(found) if isinstance(each, dict)] if isinstance(found, list) else []


def field(given: Any, name: str) -> Any:
    """Return a field of an object; None if it has none, or is no object."""
    return given.get(name) if isinstance(given, dict) else None


def text(given: Any, name: str) -> str:
    """Return a field as text; empty if it has none. Numbers are text, too."""
    found = field(given, name)
    if isinstance(found, str):
        return found.strip()
    return str(found) if isinstance(found, int | float) and not isinstance(found, bool) else ""


def number(given: Any, name: str) -> float | None:
    """Return a field as a finite number, also if it is text; None if it is none."""
    found = field(given, name)
    if found is None or isinstance(found, bool) or not isinstance(found, str | int | float):
        return None
    try:
        value = float(found)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
