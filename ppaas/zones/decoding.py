"""Files of zones as JSON, in any encoding of Unicode and with numbers that are none; and files that are no zones."""

import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

from ppaas.errors import InvalidZones
from ppaas.zones.faults import Notes

# -- files that are no zones, such as graphs of routes -----------------------------------------------------------------

LANES = "`ppaas map import-graph MAP FILE` makes lanes, zones and stations of it"
"""What makes zones of a graph."""

_OF_KEYS: Sequence[tuple[set[str], str]] = (
    ({"metaInformation", "layouts"}, f"this is a layout of LIF (VDMA), not zones of GeoJSON: {LANES}"),
    ({"levels", "building_name"}, f"this is a map or navigation graph of Open-RMF, not zones of GeoJSON: {LANES}"),
    ({"zoneSet", "zoneSetId"}, "this is a zoneSet of VDA 5050, not GeoJSON: give it with --vda5050"),
    ({"arcs", "objects"}, "this is TopoJSON: export it as GeoJSON"),
    ({"geometryType", "spatialReference"}, "this is JSON of Esri: export it as GeoJSON"),
)
"""What a file is by its members, of which it has one or more."""

_RMF_YAML = re.compile(r"^(building_name|levels|crowd_sim|reference_level_name)\s*:", re.MULTILINE)

_EDGE = {"startid", "endid"}
"""Properties of the edges of a route graph."""


def foreign_file(tree: Mapping[str, Any]) -> str:
    """Return what a decoded file is that is not GeoJSON of zones, and what to do; empty if that is not known."""
    features = tree.get("features")
    if isinstance(features, list):
        return _route_graph(features)
    if tree.get("type") == "Feature" or "coordinates" in tree or "geometries" in tree:
        return f"zones must be a FeatureCollection of GeoJSON, not one {tree.get('type')!s:.40}: put it into 'features'"
    return next((text for keys, text in _OF_KEYS if keys & tree.keys()), "")


def foreign_text(text: str) -> str:
    """Return what a text is that is not JSON, and what to do; empty if that is not known."""
    if text.lstrip().startswith("<"):
        return (
            "zones are not valid JSON: this is XML, such as KML or Lanelet2; export it as GeoJSON, in metres on the "
            f"map; of Lanelet2, {LANES}"
        )
    if _RMF_YAML.search(text):
        return f"zones are not valid JSON: this is YAML of Open-RMF, a building map or navigation graph: {LANES}"
    if _is_sequence(text):
        return "zones are not valid JSON: these are features one by one (GeoJSONSeq): export one FeatureCollection"
    return ""


def _is_sequence(text: str) -> bool:
    """Return whether each line of a text is a feature (RFC 8142, and newline-delimited GeoJSON)."""
    first = text.lstrip("\x1e \r\n").partition("\n")[0]
    try:
        tree = msgspec.json.decode(first)
    except (msgspec.DecodeError, UnicodeError, RecursionError):
        return False
    return isinstance(tree, dict) and tree.get("type") == "Feature"


def _route_graph(features: Sequence[Any]) -> str:
    rules = [_members(feature, "properties") for feature in features]
    edges = sum(rule.keys() >= _EDGE for rule in rules)
    nodes = sum(
        "kind" not in rule and _members(feature, "geometry").get("type") == "Point"
        for rule, feature in zip(rules, features, strict=True)
    )
    if not edges:
        return ""
    return (
        f"this is a route graph of Nav2 with {nodes} nodes and {edges} edges ('startid', 'endid'), not zones: {LANES}"
    )


def _members(feature: Any, key: str) -> Mapping[str, Any]:
    found = feature.get(key) if isinstance(feature, Mapping) else None
    return found if isinstance(found, Mapping) else {}


# -- JSON --------------------------------------------------------------------------------------------------------------


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
