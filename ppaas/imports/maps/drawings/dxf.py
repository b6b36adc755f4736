"""Floor plans as DXF, read by ezdxf. Doors are open, by the names of their layers and blocks."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.imports.drawing_file import UNITS, ReadDrawing, read_drawing, unit_code
from ppaas.imports.maps.common.imported_map import grid_around
from ppaas.imports.maps.drawings.names import is_door, is_other
from ppaas.imports.maps.drawings.plan_picture import DrawnPlan, PlanOptions
from ppaas.imports.plain_entities import PlainEntity
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import GridInfo

MOST_ENTITIES = 500_000
"""Largest number of entities, with those of blocks counted as often as they are inserted."""

MOST_DEPTH = 8
"""Largest depth of blocks in blocks."""

FAR = 10_000.0
"""Coordinates beyond it become relative to the lower-left corner [m]."""

MARGIN = 0.5
"""Border around the drawing [m]."""

_LINES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE", "SOLID", "TRACE", "HATCH", "MLINE")
_AREAS = ("SOLID", "TRACE", "HATCH")
_Corners = NDArray[np.float64]


def draw_dxf(content: bytes, options: PlanOptions, report: ImportReport) -> DrawnPlan:
    """Return a drawing as plan.

    Raises
    ------
    InvalidMap
        It is no DXF, has no lines, or would be too large.
    InvalidInput
        The drawing has neither units nor a scale.
    Unavailable
        ezdxf is not installed.
    """
    try:
        drawing = read_drawing(content, report.source, "drawings")
    except InvalidInput as error:
        raise InvalidMap(str(error)) from error
    if drawing.faults:
        report.translated("file", f"{drawing.faults} faults of the drawing were mended or left out by ezdxf")
    unit = _unit(drawing.document, options, report)
    paths = list(_paths(drawing, options, options.resolution / 2.0 / unit, report))
    if not paths:
        raise InvalidMap("the DXF has no lines that are walls: name their layers with --layer NAME")
    corners = np.concatenate([path for path, _ in paths]) * unit
    low, high = corners.min(axis=0), corners.max(axis=0)
    if np.abs([low, high]).max() > FAR:
        report.translated("origin", f"{low[0] / unit:.6g}, {low[1] / unit:.6g} of the drawing becomes 0, 0")
        paths = [(path - low / unit, is_area) for path, is_area in paths]
        low, high = np.zeros(2), high - low
    info = grid_around(low - MARGIN, high + MARGIN, options.resolution)
    return DrawnPlan(_picture(paths, unit, info), options.resolution, (info.origin.x, info.origin.y))


def _picture(paths: list[tuple[_Corners, bool]], unit: float, info: GridInfo) -> NDArray[np.uint8]:
    """Return lines and areas, with corners in units of so many metres, drawn in black on white."""
    picture = Image.new("L", (info.width, info.height), 255)
    brush = ImageDraw.Draw(picture)
    pixels = (np.concatenate([path for path, _ in paths]) * unit - (info.origin.x, info.origin.y)) / info.resolution
    points = np.column_stack((pixels[:, 0], info.height - pixels[:, 1])).ravel().tolist()
    end = 0
    for path, is_area in paths:
        begin, end = end, end + path.size
        corners = points[begin:end]
        brush.polygon(corners, fill=0) if is_area else brush.line(corners, fill=0)
    return np.asarray(picture)


def _unit(document: Any, options: PlanOptions, report: ImportReport) -> float:
    """Return the metres of a unit of the drawing."""
    code = unit_code(document)
    if options.scale is not None:
        unit = options.scale.unit
        if code in UNITS and not math.isclose(unit, UNITS[code], rel_tol=0.05):
            report.without_effect("$INSUNITS", f"{UNITS[code]:g} m by the file, but {unit:.4g} m by --scale-by")
        return unit
    if code not in UNITS:
        raise InvalidInput(
            f"the DXF names no unit ($INSUNITS is {code}): give two points and their distance, "
            "--scale-by X1,Y1,X2,Y2,METRES"
        )
    report.taken("$INSUNITS", f"a unit is {UNITS[code]:g} m")
    return UNITS[code]


# -- walls of a drawing ------------------------------------------------------------------------------------------------


def _paths(
    drawing: ReadDrawing, options: PlanOptions, tolerance: float, report: ImportReport
) -> Iterator[tuple[_Corners, bool]]:
    """Yield the corners of the lines and areas that are walls, and whether each is an area."""
    from ezdxf import path as paths  # noqa: PLC0415 - needed for these files alone

    counts: Counter[tuple[str, str]] = Counter()
    reasons: dict[str, str] = {}
    for entity, layer in _entities(drawing.entities(), counts, ""):
        if layer not in reasons:
            reasons[layer] = _reason(drawing.document, layer, options)
        reason = reasons[layer]
        counts[layer, reason] += 1
        if reason:
            continue
        if isinstance(entity, PlainEntity):
            if np.isfinite(entity.points).all():
                yield entity.points, False
            continue
        is_area = entity.dxftype() in _AREAS
        try:
            parts = paths.from_hatch(entity) if entity.dxftype() == "HATCH" else [paths.make_path(entity)]
            for part in parts:
                corners = np.array([(each.x, each.y) for each in part.flattening(tolerance)], np.float64)
                if len(corners) >= 2 and np.isfinite(corners).all():
                    yield corners, is_area and len(corners) > 2
        except (TypeError, ValueError, ArithmeticError) as error:
            counts[layer, f"damaged: {error}"] += 1
    _report_layers(counts, report)


def _entities(
    container: Iterable[Any], counts: Counter[tuple[str, str]], inherited: str, depth: int = 0
) -> Iterator[tuple[Any, str]]:
    """Yield entities with their layers; those of blocks on the layer 0 have the layer of the insertion."""
    for entity in container:
        is_plain = isinstance(entity, PlainEntity)
        layer = entity.layer if is_plain else str(entity.dxf.get("layer", "0"))
        layer = inherited if layer == "0" and inherited else layer
        kind = entity.kind if is_plain else entity.dxftype()
        if sum(counts.values()) > MOST_ENTITIES:
            raise InvalidMap(f"the DXF has more than {MOST_ENTITIES} entities, with those of its blocks")
        if kind == "INSERT":
            if is_door(str(entity.dxf.get("name", ""))):
                counts[layer, "doors: open"] += 1
            elif depth < MOST_DEPTH and entity.mcount <= 10_000:
                for each in entity.multi_insert() if entity.mcount > 1 else (entity,):
                    yield from _entities(each.virtual_entities(), counts, layer, depth + 1)
            else:
                counts[layer, "blocks in blocks: too many"] += 1
        elif kind in _LINES:
            yield entity, layer
        else:
            counts[layer, f"{kind}: no wall"] += 1


def _reason(document: Any, layer: str, options: PlanOptions) -> str:
    """Return why a layer has no walls; empty if it has."""
    if options.layers:
        return "" if layer in options.layers else "not named by --layer"
    if document.layers.has_entry(layer):
        entry = document.layers.get(layer)
        if entry.is_off() or entry.is_frozen():
            return "switched off"
    if is_door(layer):
        return "doors: open"
    return "dimensions, furniture or notes by its name" if is_other(layer) else ""


def _report_layers(counts: Counter[tuple[str, str]], report: ImportReport) -> None:
    for (layer, reason), count in counts.items():
        part, text = f"layer {layer}", f"{count} entities"
        if not reason:
            report.taken(part, f"{text}: walls")
        elif reason.startswith("doors"):
            report.translated(part, f"{text}: {reason}")
        elif reason.startswith(("damaged", "blocks")):
            report.refused(part, f"{text}: {reason}")
        else:
            report.without_effect(part, f"{text}: {reason}")
