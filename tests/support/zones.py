"""Zones for tests."""

from ppaas.zones.shapes import Polygon
from ppaas.zones.zone import Rule, Zone


def rectangle(rule: Rule, low_x: float, low_y: float, high_x: float, high_y: float) -> Zone:
    """Return a zone between two corners [m]."""
    ring = [[low_x, low_y], [high_x, low_y], [high_x, high_y], [low_x, high_y], [low_x, low_y]]
    return Zone(Polygon([ring]), rule)  # type: ignore[arg-type]
