"""Files that users have and that are no zones, such as graphs of routes: what each is, and what zones need instead."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

import msgspec

LANES = (
    "a lane is a feature with the geometry LineString and the properties "
    '{"name": "…", "kind": "lane"}, and "one_way": true where no edge leads back; nodes are not needed'
)
"""What lanes need."""

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
            "zones are not valid JSON: this is XML, such as KML or Lanelet2; export it as GeoJSON, in metres on the map"
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
