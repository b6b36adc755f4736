"""Features of GeoJSON for tests."""

import json
from typing import Any

SQUARE = {"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]]}
LINE = {"type": "LineString", "coordinates": [[0, 0], [1, 0]]}


def feature(geometry: Any = SQUARE, **properties: Any) -> dict[str, Any]:
    """Return a zone, a keep-out zone of the name ``a`` if nothing else is given."""
    return {"type": "Feature", "geometry": geometry, "properties": {"name": "a", "kind": "keep_out"} | properties}


def collection(*features: Any, **members: Any) -> bytes:
    """Return a feature collection."""
    return json.dumps({"type": "FeatureCollection", "features": features} | members, ensure_ascii=False).encode()
