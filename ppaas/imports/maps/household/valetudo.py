"""Maps of Valetudo, the software of vacuum robots, as its REST and MQTT interfaces give them.

Coordinates are whole centimetres, and pixels of ``pixelSize`` centimetres, from the top-left corner with y down. The
lower-left corner of that space becomes the origin of the map, so that a later map of the same robot has the same frame.

Source: ``ValetudoMap.js``, ``MapLayer.js`` and the map entities of Hypfer/Valetudo.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.imports.maps.common.imported_map import (
    ImportedMap,
    KeepOutZones,
    MapOptions,
    check_cells,
    grid_of,
    in_short,
    report_cells,
)
from ppaas.imports.maps.household.json_content import decoded_json
from ppaas.imports.report import ImportReport
from ppaas.maps.grid import GridInfo

MARGIN = 4
"""Unknown cells around the pixels of the layers."""

WALL_WIDTH = 0.1
"""Width of the zone of a virtual wall [m]."""

FREE_LAYERS, OCCUPIED_LAYERS = ("floor", "segment"), ("wall",)

UNUSED = {
    "path": "the way that the robot took is no part of a map",
    "predicted_path": "the way that the robot will take is no part of a map",
    "active_zone": "a zone of one cleaning is no part of a map",
    "active_segment": "a room of one cleaning is no part of a map",
    "no_mop_area": "robots drive where they must not mop",
    "carpet": "carpets do not change where robots drive",
    "go_to_target": "a goal is no part of a map: send it with 'ppaas robot goal'",
    "obstacle": "things that lie about are seen by the sensors of a robot that drives",
    "virtual_threshold": "robots cross thresholds as any floor",
}
"""Entities without effect, with the reason."""

_USED = ("no_go_area", "virtual_wall", "charger_location", "robot_position")
_Pixels = NDArray[np.int64]


def is_valetudo(tree: Any) -> bool:
    """Return whether decoded JSON is a map of Valetudo, or a state of its robot that has one."""
    tree = _map_in(tree)
    return isinstance(tree, dict) and isinstance(tree.get("layers"), list) and "pixelSize" in tree


def import_valetudo(
    content: bytes, name: str, options: MapOptions | None = None, tree: Any = None
) -> tuple[ImportedMap, ImportReport]:
    """Import a map of Valetudo.

    Parameters
    ----------
    content : bytes
        JSON, also packed by zlib or gzip, in Base64, or in the text of a PNG.
    name : str
        Name of the file, for the report.
    options : MapOptions, optional
    tree : any, optional
        The decoded JSON, if it is decoded already.

    Raises
    ------
    InvalidMap
        It is not a map of Valetudo, it has no free cell, or too many cells.
    """
    options = options or MapOptions()
    tree = _map_in(decoded_json(content) if tree is None else tree)
    if not is_valetudo(tree):
        raise InvalidMap("the file is not a map of Valetudo: it needs 'layers' and 'pixelSize'")
    report = ImportReport(name)
    pixel, height = _scale(tree)
    if options.resolution is not None and not math.isclose(options.resolution, pixel):
        report.refused("--resolution", f"the pixels of the file are {pixel:g} m, and stay as they are")
    free, occupied = _layers(tree["layers"], report)
    low, high = _bounds([*free, *occupied])
    width, rows = (high - low + 1 + 2 * MARGIN).tolist()
    check_cells(width, rows, pixel)
    x, y = float(low[0] - MARGIN) * pixel, float(height - high[1] - 1 - MARGIN) * pixel
    info = GridInfo(pixel, int(width), int(rows), Pose2D(in_short(x), in_short(y), 0.0))
    grid = grid_of(info, *(_mask(runs, info, low, high) for runs in (free, occupied)))
    report_cells(report, grid)
    zones = KeepOutZones(report)
    _entities(tree.get("entities"), height * pixel, zones, report)
    return ImportedMap(grid, zones=zones.zones()).anchored(options.anchor), report


def _map_in(tree: Any) -> Any:
    """Return the map in a state of a robot, or the tree itself."""
    inner = tree.get("map") if isinstance(tree, dict) else None
    return inner if isinstance(inner, dict) else tree


def _scale(tree: dict[str, Any]) -> tuple[float, float]:
    """Return the edge of a pixel [m] and the height of the space [pixels]; 0 if the file does not have it."""
    pixel, size = tree["pixelSize"], tree.get("size")
    if not _is_number(pixel) or not 0.1 <= pixel <= 1000.0:
        raise InvalidMap(f"'pixelSize' must be a number of centimetres, not {pixel!r}")
    height = size.get("y", 0) if isinstance(size, dict) else 0
    return pixel / 100.0, height / pixel if _is_number(height) else 0.0


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)


# -- layers ------------------------------------------------------------------------------------------------------------


def _layers(layers: list[Any], report: ImportReport) -> tuple[list[_Pixels], list[_Pixels]]:
    """Return the runs of the free and of the occupied layers, each (n, 3): x, y and length."""
    free: list[_Pixels] = []
    occupied: list[_Pixels] = []
    for number, layer in enumerate(layers):
        kind = layer.get("type") if isinstance(layer, dict) else None
        part = f"layers[{number}] {kind}{_title(layer)}"
        if kind not in (*FREE_LAYERS, *OCCUPIED_LAYERS):
            report.refused(part, f"unknown layer; known: {', '.join((*FREE_LAYERS, *OCCUPIED_LAYERS))}")
            continue
        try:
            runs = _runs(layer)
        except InvalidMap as error:
            report.refused(part, str(error))
            continue
        (free if kind in FREE_LAYERS else occupied).append(runs)
        becomes = "free" if kind in FREE_LAYERS else "occupied"
        report.translated(part, f"{int(runs[:, 2].sum())} {becomes} cells")
    if not free:
        raise InvalidMap("the map has no layer of the type 'floor' or 'segment', so no cell is free")
    return free, occupied


def _title(layer: Any) -> str:
    data = layer.get("metaData") if isinstance(layer, dict) else None
    if not isinstance(data, dict):
        return ""
    name = data.get("name") or data.get("segmentId")
    return "" if name is None else f" {name!s:.40}"


def _runs(layer: dict[str, Any]) -> _Pixels:
    """Return the pixels of a layer as runs; older versions list each pixel instead."""
    packed, plain = layer.get("compressedPixels"), layer.get("pixels")
    if packed:
        runs = _numbers(packed, 3)
    elif plain:
        pixels = _numbers(plain, 2)
        runs = np.concatenate((pixels, np.ones((len(pixels), 1), np.int64)), axis=1)
    else:
        raise InvalidMap("the layer has no pixels")
    if (runs[:, 2] < 1).any() or (np.abs(runs) > 1 << 20).any():
        raise InvalidMap("the layer has pixels outside of any map")
    return runs


def _numbers(values: Any, columns: int) -> _Pixels:
    try:
        numbers = np.asarray(values)
    except (ValueError, OverflowError, TypeError) as error:
        raise InvalidMap("the pixels of the layer are not a list of numbers") from error
    if numbers.ndim != 1 or numbers.dtype.kind not in "iu" or len(numbers) % columns:
        raise InvalidMap(f"the pixels of the layer are not a list of whole numbers, {columns} for each")
    return numbers.astype(np.int64).reshape(-1, columns)


def _bounds(layers: Sequence[_Pixels]) -> tuple[_Pixels, _Pixels]:
    """Return the least and the greatest x and y of all pixels."""
    low = np.min([runs[:, :2].min(axis=0) for runs in layers], axis=0)
    high = np.max([(runs[:, 0] + runs[:, 2] - 1).max() for runs in layers])
    return low, np.array([high, np.max([runs[:, 1].max() for runs in layers])])


def _mask(layers: Sequence[_Pixels], info: GridInfo, low: _Pixels, high: _Pixels) -> NDArray[np.bool_]:
    """Return the cells of runs: a run adds 1 at its begin and takes it off behind its end."""
    changes = np.zeros(info.height * (info.width + 1), np.int32)
    one = np.int32(1)  # of the same type as the changes: NumPy adds others a hundred times slower
    for runs in layers:
        begins = (high[1] - runs[:, 1] + MARGIN) * (info.width + 1) + runs[:, 0] - low[0] + MARGIN
        np.add.at(changes, begins, one)
        np.add.at(changes, begins + runs[:, 2], -one)
    np.cumsum(changes, out=changes)
    return np.asarray(changes.reshape(info.height, info.width + 1)[:, :-1] > 0)


# -- entities ----------------------------------------------------------------------------------------------------------


def _entities(entities: Any, top: float, zones: KeepOutZones, report: ImportReport) -> None:
    """Report the entities of a map; areas and walls become zones. ``top`` is the height of the space [m]."""
    for number, entity in enumerate(entities if isinstance(entities, list) else ()):
        kind = entity.get("type") if isinstance(entity, dict) else None
        part = f"entities[{number}] {kind}"
        points = _points(entity, top)
        if kind in UNUSED:
            report.without_effect(part, UNUSED[str(kind)])
        elif kind not in _USED:
            near = report.nearest_name(str(kind), (*UNUSED, *_USED))
            report.refused(part, "unknown entity" + (f"; did you mean {near!r}?" if near else ""))
        elif points is None:
            report.refused(part, "its 'points' are not a list of numbers, two for each")
        elif kind == "no_go_area":
            zones.add(part, f"no-go area {number}", points)
        elif kind == "virtual_wall":
            zones.add(part, f"virtual wall {number}", wall_corners(points), f", {WALL_WIDTH:g} m wide")
        else:
            report.without_effect(part, f"a map has no robots: it is at {_pose(entity, points[0])}")


def _points(entity: Any, top: float) -> list[tuple[float, float]] | None:
    values = entity.get("points") if isinstance(entity, dict) else None
    if not isinstance(values, list) or not values or len(values) % 2 or not all(map(_is_number, values)):
        return None
    pairs = zip(values[::2], values[1::2], strict=True)
    return [(x / 100.0, top - y / 100.0) for x, y in pairs]


def wall_corners(line: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the corners of the zone around a virtual wall, whose ends are the first and the last point [m]."""
    (ax, ay), (bx, by) = line[0], line[-1]
    length = math.hypot(bx - ax, by - ay) or 1.0
    x, y = (by - ay) / length * WALL_WIDTH / 2.0, (ax - bx) / length * WALL_WIDTH / 2.0
    return [(ax + x, ay + y), (bx + x, by + y), (bx - x, by - y), (ax - x, ay - y)]


def _pose(entity: dict[str, Any], place: tuple[float, float]) -> str:
    """Return a pose in words; angles of Valetudo are clockwise from the top of the map."""
    data = entity.get("metaData")
    angle = data.get("angle") if isinstance(data, dict) else None
    where = f"x={place[0]:.2f}, y={place[1]:.2f}"
    if not isinstance(angle, int | float) or not math.isfinite(angle):
        return where
    return f"{where}, yaw={math.radians(90.0 - angle) % math.tau:.2f}"
