"""Centre lines of drawings in DXF, by ezdxf: lines, polylines, arcs and splines of some layers, as lanes."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ppaas.errors import InvalidInput
from ppaas.fleet.lane_drawing import DrawnLane, network_of
from ppaas.imports.drawing_file import UNITS, read_drawing, unit_code
from ppaas.imports.graphs.model.route_graph import GraphEdge, GraphNode, GraphOptions, Place, ReadGraph, RouteGraph
from ppaas.imports.plain_entities import PlainEntity
from ppaas.imports.report import ImportReport
from ppaas.zones.zone import MOST_ON_LANES

LANE_LAYER = re.compile(r"lane|route|path|cent(er|re)|agv|amr|track|guide|fahr|weg|voie|trajet", re.IGNORECASE)
"""Names of layers that are taken for lanes if none is named."""

ONE_WAY_LAYER = re.compile(r"one[ _-]?way|einbahn|sens[ _-]?unique", re.IGNORECASE)
"""Names of layers whose lines are for one way, in the direction in which they were drawn."""

DRAWN = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "SPLINE", "ELLIPSE", "CIRCLE")

OFF = 0.02
"""Distance between a curve and its corners [m]."""

LARGEST = 2000.0
"""Largest extent of a building [m], by which a drawing without a unit is judged."""

MOST_ENTITIES = 200_000
"""Largest number of entities that are looked at, with those of blocks."""

DEEPEST = 4
"""Largest number of blocks that are in each other."""


def read_dxf(content: bytes, report: ImportReport, options: GraphOptions) -> ReadGraph:
    """Read the centre lines of a drawing.

    Raises
    ------
    InvalidInput
        It is no drawing, or no layer of it has lanes; the text names the layers that have lines.
    Unavailable
        ezdxf is not installed.
    """
    drawing = read_drawing(content, report.source, "graphs")
    if drawing.faults:
        report.translated("file", f"{drawing.faults} faults of the drawing were mended or left out by ezdxf")
    by_layer: dict[str, list[Any]] = {}
    others: dict[str, int] = {}
    for entity in _entities(drawing.entities()):
        is_plain = isinstance(entity, PlainEntity)
        kind = entity.kind if is_plain else entity.dxftype()
        if kind in DRAWN:
            by_layer.setdefault(entity.layer if is_plain else entity.dxf.layer, []).append(entity)
        else:
            others[kind] = others.get(kind, 0) + 1
    layers = _chosen(by_layer, options, report)
    for kind, count in sorted(others.items()):
        report.without_effect(f"{count} {kind}", "only lines, polylines, arcs and splines are lanes")
    scale = _scale(drawing.document, [each for layer in layers for each in by_layer[layer]], report, options)
    lines = [line for layer in layers for line in _lines(layer, by_layer[layer], scale, report)]
    return ReadGraph(_graph(lines, report), report)


def _entities(model: Iterable[Any]) -> Iterator[Any]:
    """Yield the entities of a model, and those of its blocks."""
    left = MOST_ENTITIES
    waiting = [(entity, 0) for entity in model][::-1]
    while waiting and left:
        entity, depth = waiting.pop()
        left -= 1
        if not isinstance(entity, PlainEntity) and entity.dxftype() == "INSERT" and depth < DEEPEST:
            waiting += [(each, depth + 1) for each in entity.virtual_entities()][::-1]
        else:
            yield entity
    if waiting:
        raise InvalidInput(f"the drawing has more than {MOST_ENTITIES} entities: leave out blocks and layers")


def _chosen(by_layer: dict[str, list[Any]], options: GraphOptions, report: ImportReport) -> list[str]:
    listed = ", ".join(f"{name} ({len(found)} lines)" for name, found in sorted(by_layer.items())[:30])
    if not by_layer:
        raise InvalidInput(f"{report.source} has no lines, polylines, arcs or splines")
    if options.layers:
        wanted = {name.lower() for name in options.layers}
        chosen = [name for name in by_layer if name.lower() in wanted]
        missing = wanted - {name.lower() for name in chosen}
        if missing:
            raise InvalidInput(f"{report.source} has no lines on the layer {min(missing)!r}: it has {listed}")
    else:
        chosen = [name for name in by_layer if LANE_LAYER.search(name)] or (
            list(by_layer) if len(by_layer) == 1 else []
        )
        if not chosen:
            raise InvalidInput(f"which layers of {report.source} have the lanes? Give --layer NAME; there are {listed}")
    for name, found in by_layer.items():
        if name not in chosen:
            report.without_effect(f"layer {name}", f"{len(found)} lines, not of lanes; --layer {name} takes them")
    return chosen


def _scale(document: Any, entities: Sequence[Any], report: ImportReport, options: GraphOptions) -> float:
    """Return the metres of a unit of the drawing, and report where they come from."""
    from ezdxf import bbox, units  # noqa: PLC0415 - only drawings need it

    if options.scale is not None:
        report.translated("$INSUNITS", f"a unit is {options.scale:g} m, by --scale")
        return options.scale
    code = unit_code(document)
    if code in UNITS:
        report.translated("$INSUNITS", f"the unit is {units.unit_name(code)}: {UNITS[code]:g} m")
        return UNITS[code]
    box = bbox.extents((each for each in entities if not isinstance(each, PlainEntity)), fast=True)
    box.extend(point for each in entities if isinstance(each, PlainEntity) for point in each.points.tolist())
    size = max(box.size.x, box.size.y) if box.has_data else 0.0
    scale = 1.0 if size <= LARGEST else 0.001
    unit = "metres" if scale == 1.0 else "millimetres"
    report.translated(
        "$INSUNITS",
        f"the drawing has no known unit; it is {size:g} wide, so {unit} were taken: if not, give --scale METRES",
    )
    return scale


def _lines(layer: str, entities: Sequence[Any], scale: float, report: ImportReport) -> list[DrawnLane]:
    from ezdxf.path import make_path  # noqa: PLC0415 - only drawings need it

    one_way = bool(ONE_WAY_LAYER.search(layer))
    found: list[DrawnLane] = []
    for entity in entities:
        is_plain = isinstance(entity, PlainEntity)
        name = f"{layer} {(entity.handle if is_plain else entity.dxf.get('handle')) or len(found) + 1}"
        try:
            corners = entity.points if is_plain else [(at.x, at.y) for at in make_path(entity).flattening(OFF / scale)]
            points = [(float(scale * x), float(scale * y)) for x, y in corners]
        except (TypeError, ValueError, ZeroDivisionError) as error:
            report.refused(name, f"{error!s:.100}")
            continue
        if not all(math.isfinite(each) for point in points for each in point) or _length(points) <= OFF:
            report.refused(name, "it has no length")
            continue
        found.append(DrawnLane(name, np.array(points), one_way))
    way = "one way, as they were drawn" if one_way else "both ways: lines of drawings have no direction"
    report.translated(f"layer {layer}", f"{len(found)} lines, as lanes {way}")
    return found


def _length(points: Sequence[Place]) -> float:
    return sum(math.dist(one, other) for one, other in pairwise(points))


def _graph(lines: Sequence[DrawnLane], report: ImportReport) -> RouteGraph:
    """Return the graph of lines, which are connected where they meet or cross."""
    size = sum(len(line.points) for line in lines)
    if size > 5 * MOST_ON_LANES:
        raise InvalidInput(
            f"the lines of {report.source} have {size} positions, and lanes may have {MOST_ON_LANES}: choose fewer "
            "layers with --layer NAME"
        )
    if not lines:
        return RouteGraph({}, [], [], [])
    places, names = network_of(lines)
    nodes = {str(at): GraphNode("", (float(x), float(y)), f"({x:.2f}, {y:.2f})") for at, (x, y) in enumerate(places)}
    edges = [GraphEdge(name, str(one), str(other), (), None, None, "", name) for (one, other), name in names.items()]
    return RouteGraph(nodes, edges, [], [])
