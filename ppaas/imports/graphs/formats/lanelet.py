"""Maps of Lanelet2 (OSM XML): the centre line of each lanelet between its two borders, as a lane."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.distribution import install_hint
from ppaas.errors import InvalidInput, Unavailable
from ppaas.imports.graphs.model.cleaning import GraphBuilder
from ppaas.imports.graphs.model.degrees import metres_around
from ppaas.imports.graphs.model.gathered import GatheredNotes
from ppaas.imports.graphs.model.route_graph import GraphEdge, GraphNode, GraphOptions, Place, ReadGraph
from ppaas.imports.report import ImportReport

FOR_OTHERS = ("crosswalk", "stairs", "walkway", "bicycle_lane", "rail")
"""Subtypes of lanelets that are not for robots that drive."""

OFF = 0.02
"""Distance between a centre line and its corners [m]."""

_SPEED = re.compile(r"^\s*([0-9.]+)\s*(km/h|kmh|mph|m/s|mps)?\s*$")
_UNITS = {None: 1 / 3.6, "km/h": 1 / 3.6, "kmh": 1 / 3.6, "mph": 0.44704, "m/s": 1.0, "mps": 1.0}

_Tags = Mapping[str, str]


def read_lanelets(content: bytes, report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Read the lanelets of a map.

    Raises
    ------
    InvalidInput
        It is no XML of OSM, or positions are degrees and there is no anchor.
    Unavailable
        defusedxml is not installed.
    """
    root = _root(content, report)
    notes = GatheredNotes()
    places = _places(root, report, options)
    ways = {str(way.get("id")): [str(nd.get("ref")) for nd in way.iter("nd")] for way in root.iter("way")}
    builder = GraphBuilder(notes)
    for relation in root.iter("relation"):
        tags = _tags(relation)
        part = f"relation {relation.get('id')}"
        if tags.get("type") != "lanelet":
            notes.without_effect(
                f"{part} {tags.get('subtype', tags.get('type', ''))}".strip(),
                "no lanelet; rules and areas are not imported",
            )
        elif tags.get("subtype") in FOR_OTHERS:
            notes.without_effect(part, f"a lanelet for others: {tags['subtype']}")
        else:
            _read_lanelet(builder, part, tags, _borders(relation, ways, places), places, notes=notes)
    for way in root.iter("way"):
        if _tags(way).get("type") == "lanelet":
            notes.refused(f"way {way.get('id')}", "a lanelet is a relation of two borders, no way")
    if builder.graph.nodes:
        report.taken(f"{len(builder.graph.nodes)} ends of lanelets", "ends of lanes")
    notes.write(report)
    return ReadGraph(builder.graph, report)


def _root(content: bytes, report: ImportReport) -> Any:
    try:
        from defusedxml import DefusedXmlException, ElementTree  # noqa: PLC0415 - only maps of Lanelet2 need it
    except ImportError as error:
        raise Unavailable(f"maps of Lanelet2 need defusedxml: {install_hint('graphs')}") from error
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, DefusedXmlException, ValueError, LookupError) as error:
        raise InvalidInput(f"{report.source} is no XML that can be read: {error!s:.200}") from error
    if root.tag != "osm":
        raise InvalidInput(f"{report.source} is XML of {root.tag!s:.40}, not of OSM with lanelets")
    return root


def _tags(element: Any) -> _Tags:
    return {str(tag.get("k")): str(tag.get("v")) for tag in element.findall("tag")}


def _places(root: Any, report: ImportReport, options: GraphOptions) -> dict[str, Place]:
    """Return the positions of nodes in metres: local ones, where the file has them, or those around the anchor."""
    local: dict[str, Place] = {}
    degrees: dict[str, Place] = {}
    for node in root.iter("node"):
        tags, key = _tags(node), str(node.get("id"))
        for x, y in (("local_x", "local_y"), ("x", "y")):
            if (place := _pair(tags.get(x), tags.get(y))) is not None:
                local[key] = place
                break
        if (place := _pair(node.get("lon"), node.get("lat"))) is not None:
            degrees[key] = place
    if local and options.anchor is None:
        report.taken("positions", "local x and y of the nodes")
        return local
    if not degrees:
        raise InvalidInput(f"{report.source} has no nodes with positions")
    report.translated("positions", "longitudes and latitudes, in metres around the anchor")
    return dict(zip(degrees, metres_around(list(degrees.values()), options.anchor, report.source), strict=True))


def _pair(x: str | None, y: str | None) -> Place | None:
    try:
        found = float(x or "nan"), float(y or "nan")
    except ValueError:
        return None
    return found if all(map(math.isfinite, found)) else None


def _borders(relation: Any, ways: Mapping[str, Sequence[str]], places: Mapping[str, Place]) -> dict[str, list[str]]:
    """Return the nodes of the borders and of the centre line of a lanelet, by their roles."""
    return {
        str(member.get("role")): [key for key in ways.get(str(member.get("ref")), ()) if key in places]
        for member in relation.findall("member")
        if member.get("role") in ("left", "right", "centerline")
    }


def _read_lanelet(
    builder: GraphBuilder,
    part: str,
    tags: _Tags,
    borders: Mapping[str, Sequence[str]],
    places: Mapping[str, Place],
    *,
    notes: GatheredNotes,
) -> None:
    if min(len(borders.get("left", ())), len(borders.get("right", ()))) < 2:
        notes.refused(part, "a lanelet needs a left and a right border with two nodes or more")
        return
    left, right = _along(borders["left"], borders["right"], places)
    line = _centre(left, right, borders.get("centerline", ()), places)
    ends = [f"{left[at]} {right[at]}" for at in (0, -1)]
    for key, place in zip(ends, (line[0], line[-1]), strict=True):
        if key not in builder.graph.nodes:
            builder.add_node(key, GraphNode("", place, part))
    limit = _limit(tags.get("speed_limit"), part, notes)
    name = part.replace("relation", "lanelet")
    between = tuple(line[1:-1])
    builder.add_edge(GraphEdge(name, ends[0], ends[1], between, limit, None, "", part))
    if tags.get("one_way") in ("no", "false"):
        builder.add_edge(GraphEdge(name, ends[1], ends[0], between[::-1], limit, None, "", part))
    for key in sorted(tags.keys() - {"type", "subtype", "one_way", "speed_limit"}):
        notes.without_effect(f"{part}.{key}", "no tag of lanelets that lanes have")


def _along(
    left: Sequence[str], right: Sequence[str], places: Mapping[str, Place]
) -> tuple[Sequence[str], Sequence[str]]:
    """Return the borders in the direction of driving: the left one is on its left."""
    same = math.dist(places[left[0]], places[right[0]]) + math.dist(places[left[-1]], places[right[-1]])
    crossed = math.dist(places[left[0]], places[right[-1]]) + math.dist(places[left[-1]], places[right[0]])
    if crossed < same:
        right = right[::-1]
    ring = np.array([places[key] for key in [*right, *left[::-1]]])
    x, y = ring.T
    area = float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
    return (left, right) if area >= 0.0 else (left[::-1], right[::-1])


def _centre(
    left: Sequence[str], right: Sequence[str], given: Sequence[str], places: Mapping[str, Place]
) -> list[Place]:
    """Return the centre line: the one that is given, or the middle between the borders."""
    import shapely  # noqa: PLC0415 - only imports of graphs need it

    one, other = (np.array([places[key] for key in border]) for border in (left, right))
    if len(given) > 1:
        middle = np.array([places[key] for key in given])
        if math.dist(middle[0], (one[0] + other[0]) / 2.0) > math.dist(middle[-1], (one[0] + other[0]) / 2.0):
            middle = middle[::-1]
        middle[0], middle[-1] = (one[0] + other[0]) / 2.0, (one[-1] + other[-1]) / 2.0
    else:
        at = np.union1d(_parts(one), _parts(other))
        middle = (_sampled(one, at) + _sampled(other, at)) / 2.0
    line = shapely.simplify(shapely.LineString(middle), OFF)
    return [(float(x), float(y)) for x, y in line.coords]


def _parts(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far along a line each of its places is, from 0 to 1."""
    along = np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))
    return np.asarray(along / (along[-1] or 1.0))


def _sampled(line: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    parts = _parts(line)
    return np.stack([np.interp(at, parts, line[:, axis]) for axis in (0, 1)], axis=1)


def _limit(text: str | None, part: str, notes: GatheredNotes) -> float | None:
    if text is None:
        return None
    found = _SPEED.match(text)
    if found is None:
        notes.refused(f"{part}.speed_limit", f"{text!r:.40} is no speed in km/h, mph or m/s")
        return None
    limit = round(float(found[1]) * _UNITS[found[2]], 4)
    if not 0.0 < limit <= 100.0:
        notes.without_effect(f"{part}.speed_limit", f"{text!r:.40} is no limit")
        return None
    notes.translated(f"{part}.speed_limit", f"a zone that limits the speed to {limit:g} m/s")
    return limit
