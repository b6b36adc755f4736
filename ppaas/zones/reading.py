"""Zones from GeoJSON (RFC 7946) as editors write it, and zones as GeoJSON."""

import re
from typing import Any, NamedTuple, get_args

import msgspec

from ppaas.decoding import converted
from ppaas.errors import InvalidZones
from ppaas.zones.decoding import decoded, foreign_file, type_of
from ppaas.zones.faults import Faults, Notes, place_text
from ppaas.zones.shapes import Geometry, first_place
from ppaas.zones.zone import KINDS, AnyRule, Zone, ZoneSet, check_zone

# -- properties of features, also after the tables of a GIS ------------------------------------------------------------

_SWITCHES = {"one_way", "strict", "charges"}
"""Properties that are true or false."""

_LISTS = {"times", "uses"}
"""Properties that are lists, which tables have as text of JSON."""

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
    if key in _LISTS and isinstance(value, str):
        try:
            return msgspec.json.decode(value)
        except msgspec.DecodeError as error:
            raise InvalidZones(f"{key!r} is text that is not valid JSON: {error!s:.100}") from error
    if key in _SWITCHES and isinstance(value, str):
        return _WORDS.get(value.strip().lower(), value)
    whole = int(value) if isinstance(value, float) and value.is_integer() else value
    is_number = isinstance(whole, int | float) and not isinstance(whole, bool)
    return str(whole) if key == "name" and is_number else whole


def _in_words(text: str) -> str:
    text = _PATTERN.sub("a time of day such as '08:30' or '24:00'", text)
    if text.endswith("`$.kind`") or "field `kind`" in text:
        return f"{text}; its kind is one of {', '.join(KINDS)}"
    if "RFC3339" in text:
        return f"{text}; give a moment such as '2026-05-01T08:00:00'"
    return text


# -- features ----------------------------------------------------------------------------------------------------------

EDITORS = {"title", "description", "layer", "path", "tessellate", "extrude", "visibility"}
"""Properties that editors of GeoJSON, QGIS and KML add, which are ignored."""

KEYS = {
    "fid",
    "id",
    "gid",
    "ogc_fid",
    "objectid",
    "index",
    "level_0",
    "level_1",
    "shape_length",
    "shape_leng",
    "shape_area",
}
"""Columns that tables of a GIS and of geopandas add, in any case, which are ignored; and all properties that begin with
the following: styles, and properties of OpenStreetMap."""

STYLES = ("stroke", "fill", "marker-", "_", "@")

DEFAULT_TIME_ZONE = "UTC"

EMPTY_PARTS = "parts without positions were left out"
_HEIGHTS = "heights were left out: zones are in the plane"

DEEPEST = 3
"""Largest number of lists that positions are in, as in a MultiPolygon."""


class ReadZones(NamedTuple):
    """Zones of a file, and what was mended in them or may be wrong."""

    zones: ZoneSet
    notes: Notes


def zones_of(text: str | bytes) -> ZoneSet:
    """Read the zones of a map from GeoJSON; see `read_zones`."""
    return read_zones(text).zones


def read_zones(text: str | bytes) -> ReadZones:
    """Read the zones of a map from GeoJSON, in any encoding of Unicode, with or without a byte-order mark.

    Foreign members, properties that editors add, heights, and ``id`` are ignored. What tables of GIS make of values is
    read as what it was: whole floats, numbers and switches as text, and ``times`` as text of JSON. The time zone of the
    set is the collection's; if it has none, its zones', if they have the same one.

    Raises
    ------
    InvalidZones
        It is not JSON or not a feature collection, or a zone is not valid; the text says which, and why.
    """
    notes = Notes()
    tree = decoded(text, notes)
    features = tree.get("features")
    if tree.get("type") != "FeatureCollection" or not isinstance(features, list):
        missing = "" if "features" in tree else ": Object missing required field `features`"
        raise InvalidZones(foreign_file(tree) or f"zones must be a FeatureCollection of GeoJSON{missing}")
    if graph := foreign_file(tree):
        raise InvalidZones(graph)
    faults = Faults()
    read = [_zone_of(number, feature, faults, notes) for number, feature in enumerate(features)]
    zones = [zone for zone in read if zone is not None]
    _check_names(zones, faults)
    faults.check()
    return ReadZones(_set_of(zones, tree.get("time_zone"), notes), notes)


def geojson_of(zones: ZoneSet) -> bytes:
    """Return zones as GeoJSON, the same bytes for the same zones."""
    return msgspec.json.encode(zones, order="deterministic")


def with_time_zones(zones: ZoneSet) -> ZoneSet:
    """Return the same zones, of which each with times names its time zone.

    Editors over GDAL keep properties of features and drop members of the collection.
    """
    return msgspec.structs.replace(zones, zones=[_with_time_zone(zones, zone) for zone in zones.zones])


def _with_time_zone(zones: ZoneSet, zone: Zone) -> Zone:
    if not zone.rule.times:
        return zone
    rule = msgspec.structs.replace(zone.rule, time_zone=zones.time_zone_of(zone))
    return msgspec.structs.replace(zone, rule=rule)


def _zone_of(number: int, feature: Any, faults: Faults, notes: Notes) -> Zone | None:
    """Read a feature; add a fault and return None if it is not a zone."""
    members = feature if isinstance(feature, dict) else {}
    properties = members.get("properties")
    if members.get("type") != "Feature" or not isinstance(properties, dict):
        what = (
            "has no properties: give it a 'name' and a 'kind'" if members.get("type") == "Feature" else "is no Feature"
        )
        faults.add(str(number), what, whole=f"features[{number}].properties: feature {number} {what}")
        return None
    given = {key: value for key, value in properties.items() if not _is_of_an_editor(key) and value is not None}
    name = given.get("name", given.get("Name", given.get("NAME", number)))
    try:
        rule = rule_of(given, notes)
    except InvalidZones as error:
        whole = f"properties of zone {name!r:.80}: {error!s:.300}"
        faults.add(str(name), f"{error!s:.300}", first_place(members.get("geometry")), whole)
        return None
    geometry = _geometry_of(rule.name, number, members.get("geometry"), faults, notes)
    if geometry is None:
        return None
    zone = Zone(geometry, rule)
    try:
        check_zone(zone)
    except InvalidZones as error:
        place = error.faults[0].place if error.faults else first_place(members.get("geometry"))
        whole = str(error) if error.faults or str(error).startswith("zone ") else f"zone {zone.name!r}: {error}"
        faults.add(zone.name, error.faults[0].text if error.faults else str(error), place, whole)
        return None
    return zone


def _is_of_an_editor(key: str) -> bool:
    return key.lower() in EDITORS | KEYS or key.startswith(STYLES)


def _check_names(zones: list[Zone], faults: Faults) -> None:
    first: dict[str, Zone] = {}
    for zone in zones:
        if (other := first.setdefault(zone.name, zone)) is not zone:
            at, then = first_place(zone.geometry.coordinates), first_place(other.geometry.coordinates)
            begins = f"; they begin at {place_text(then)} and {place_text(at)}" if then and at else ""
            whole = f"two zones have the name {zone.name!r}: rename one of them{begins}"
            faults.add(zone.name, whole, at, whole)


def _geometry_of(name: str, number: int, given: Any, faults: Faults, notes: Notes) -> Geometry | None:
    where = f"zone {name!r:.80} (features[{number}].geometry)"
    if given is None:
        faults.add(
            name, "it has no geometry", whole=f"{where} has no geometry: draw a polygon, or leave the feature out"
        )
        return None
    has_places = isinstance(given, dict) and "coordinates" in given
    try:
        plain = given | {"coordinates": _plain(given["coordinates"], name, notes)} if has_places else given
        found: Geometry = converted(plain, Geometry)
    except msgspec.ValidationError as error:
        advice = (
            "; a zone is a Polygon or MultiPolygon, a lane a LineString or MultiLineString, a station or dock a Point"
        )
        place = first_place(given)
        begins = f"; it begins at {place_text(place)}" if place else ""
        text = f"{error!s:.200}{advice if 'Invalid value' in str(error) else ''}{begins}"
        faults.add(name, text, place, whole=f"{where}: {text}")
        return None
    return found


def _plain(coordinates: Any, name: str, notes: Notes, depth: int = DEEPEST) -> Any:
    """Return coordinates in the plane, without positions that follow themselves."""
    if not depth or not isinstance(coordinates, list) or not coordinates:
        return coordinates
    if not isinstance(coordinates[0], list):
        if depth == DEEPEST and len(coordinates) > 2:
            notes.add(_HEIGHTS, name)
        return coordinates[:2] if depth == DEEPEST else coordinates
    if not all(isinstance(place, list) and place and not isinstance(place[0], list) for place in coordinates):
        parts = [_plain(part, name, notes, depth - 1) for at, part in enumerate(coordinates) if part != [] or at == 0]
        if len(parts) < len(coordinates):
            notes.add(EMPTY_PARTS, name)
        return parts
    flat = [place[:2] for place in coordinates]
    if any(len(place) > 2 for place in coordinates):
        notes.add(_HEIGHTS, name)
    kept = [place for at, place in enumerate(flat) if at == 0 or place != flat[at - 1]]
    if len(kept) < len(flat):
        notes.add("positions that follow themselves were left out", name)
    return kept


def _set_of(zones: list[Zone], given: Any, notes: Notes) -> ZoneSet:
    """Return a set whose zones have a time zone only if it differs from the set's."""
    if given is not None and not isinstance(given, str):
        raise InvalidZones(f"time_zone must be a name such as 'Europe/Berlin', not `{type_of(given)}`")
    given = (given or "").strip() or None
    timed = [zone for zone in zones if zone.rule.times]
    own = {zone.rule.time_zone for zone in timed}
    if given is None and len(own) == 1:
        given = own.pop()
    for zone in timed:
        if zone.rule.time_zone is None and given is None:
            notes.add(
                "its times have no time zone, so they are in UTC: give 'time_zone', such as \"Europe/Berlin\", as a "
                "member of the collection or as a property of the zone",
                zone.rule.name,
            )
        elif zone.rule.time_zone not in (None, given) and given is not None:
            notes.add(f"its times are in its own time zone, not in {given}, that of the collection", zone.rule.name)
    common = given or DEFAULT_TIME_ZONE
    return ZoneSet([_without_time_zone(zone, common) for zone in zones], common)


def _without_time_zone(zone: Zone, common: str) -> Zone:
    if zone.rule.time_zone is None or (zone.rule.times and zone.rule.time_zone != common):
        return zone
    return msgspec.structs.replace(zone, rule=msgspec.structs.replace(zone.rule, time_zone=None))
