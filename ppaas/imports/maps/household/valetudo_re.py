"""Maps of Valetudo RE, and of Valetudo before version 0.6, as their MQTT interfaces give them.

Pixels are 5 cm wide and points in millimetres, from the top-left corner of a space of 1024 × 1024 pixels with y down.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ppaas.errors import InvalidMap
from ppaas.imports.maps.common.imported_map import ImportedMap, MapOptions
from ppaas.imports.maps.household.json_content import decoded_json
from ppaas.imports.maps.household.valetudo import import_valetudo
from ppaas.imports.report import ImportReport

SIDE = 1024
"""Side of the space [pixels]."""

PIXEL = 5
"""Edge of a pixel [cm]."""

_LAYERS = {"floor": "floor", "walls": "wall", "obstacle_weak": "wall", "obstacle_strong": "wall"}
_LINES = {"virtual_walls": "virtual_wall"}
_AREAS = {
    "forbidden_zones": "no_go_area",
    "forbidden_mop_zones": "no_mop_area",
    "currently_cleaned_zones": "active_zone",
}
_POINTS = {"charger": "charger_location", "robot": "robot_position"}


def is_valetudo_re(tree: Any) -> bool:
    """Return whether decoded JSON is a map of Valetudo RE."""
    image = tree.get("image") if isinstance(tree, dict) else None
    return isinstance(image, dict) and {"position", "dimensions", "pixels"} <= image.keys()


def import_valetudo_re(
    content: bytes, name: str, options: MapOptions | None = None, tree: Any = None
) -> tuple[ImportedMap, ImportReport]:
    """Import a map of Valetudo RE, which becomes one of Valetudo first; parameters and errors as `import_valetudo`."""
    tree = decoded_json(content) if tree is None else tree
    if not is_valetudo_re(tree):
        raise InvalidMap("the file is not a map of Valetudo RE: it needs an 'image' with pixels")
    return import_valetudo(content, name, options, _newer(tree))


def _newer(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the map in the form of Valetudo."""
    image = tree["image"]
    layers = [_layer(_LAYERS.get(key, key), pixels, image, {}) for key, pixels in image["pixels"].items() if pixels]
    segments = image.get("segments")
    if isinstance(segments, dict):
        layers += [
            _layer("segment", pixels, image, {"segmentId": key.removeprefix("pixels_seg_")})
            for key, pixels in segments.items()
            if key.startswith("pixels_seg_") and pixels
        ]
    size = {"x": SIDE * PIXEL, "y": SIDE * PIXEL}
    return {"pixelSize": PIXEL, "size": size, "layers": layers, "entities": _entities(tree)}


def _layer(kind: str, pixels: Any, image: dict[str, Any], data: dict[str, Any]) -> dict[str, Any]:
    return {"type": kind, "metaData": data, "pixels": _places(pixels, image)}


def _places(pixels: Any, image: dict[str, Any]) -> list[int]:
    """Return x and y of the pixels of a layer.

    They are pairs, counted from the space or from the image, or numbers that count the pixels of the image row by row
    from below.
    """
    try:
        left, top = int(image["position"]["left"]), int(image["position"]["top"])
        width, height = int(image["dimensions"]["width"]), int(image["dimensions"]["height"])
        numbers: NDArray[np.int64] = np.asarray(pixels, np.int64)
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise InvalidMap("the image of the map has no whole numbers as position, dimensions and pixels") from error
    if width < 1 or height < 1 or numbers.ndim not in (1, 2) or (numbers.ndim == 2 and numbers.shape[1] != 2):
        raise InvalidMap("the image of the map has no size, or its pixels are neither numbers nor pairs")
    if numbers.ndim == 1:
        numbers = np.stack((numbers % width + left, height - 1 - numbers // width + top), axis=1)
    elif not ((numbers >= (left, top)).all() and (numbers.max(axis=0) >= (width, height)).any()):
        numbers = numbers + np.array((left, top))
    found: list[int] = numbers.ravel().tolist()
    return found


def _entities(tree: dict[str, Any]) -> list[dict[str, Any]]:
    found = [
        _entity(kind, each)
        for key, kind in (_AREAS | _LINES).items()
        for each in (tree.get(key) or () if isinstance(tree.get(key), list | None) else ())
    ]
    if isinstance(path := tree.get("path"), dict) and path.get("points"):
        found.append({"type": "path", "points": []})
    found += [_entity(kind, tree[key]) for key, kind in _POINTS.items() if tree.get(key)]
    return found


def _entity(kind: str, millimetres: Any) -> dict[str, Any]:
    points = millimetres if isinstance(millimetres, list) else []
    return {"type": kind, "points": [each / 10.0 if isinstance(each, int | float) else each for each in points]}
