"""A small building of Open-RMF: two floors of 12 m × 8 m with a lift, a door, lanes, a charger and a parking spot."""

from typing import Any

import yaml

SCALE = 0.05
"""Metres of a pixel of both floors."""


def floor(*, dx: float = 0.0, dy: float = 0.0, **members: Any) -> dict[str, Any]:
    """Return a floor whose drawing is shifted by some pixels; both floors have the fiducials A, B and C."""

    def at(x: float, y: float, *more: Any) -> list[Any]:
        return [x + dx, y + dy, 0.0, *(more or ("",))]

    vertices = [
        at(0, 0), at(240, 0), at(240, 160), at(0, 160),  # outer corners
        at(120, 0), at(120, 60), at(120, 80), at(120, 160),  # an inner wall with a door
        at(20, 120, "car"), at(20, 70, "lobby"), at(180, 70, "office", {"is_parking_spot": [4, True]}),
        at(220, 70, "charger", {"is_charger": [4, True]}),
    ]  # fmt: skip
    return {
        "elevation": 0.0,
        "measurements": [[0, 1, {"distance": [3, 12.0]}]],
        "fiducials": [[10.0 + dx, 10.0 + dy, "A"], [230.0 + dx, 10.0 + dy, "B"], [120.0 + dx, 150.0 + dy, "C"]],
        "vertices": vertices,
        "walls": [[0, 1, {}], [1, 2, {}], [2, 3, {}], [3, 0, {}], [4, 5, {}], [6, 7, {}]],
        "floors": [{"parameters": {}, "vertices": [0, 1, 2, 3]}],
        "doors": [[5, 6, {"name": [1, "office door"], "type": [1, "hinged"]}]],
        "lanes": [[8, 9, {"bidirectional": [4, True]}], [9, 10, {"bidirectional": [4, True]}], [10, 11, {}]],
    } | members


LIFT: dict[str, Any] = {
    "x": 20.0, "y": 120.0, "yaw": 0.0, "width": 1.6, "depth": 1.6, "reference_floor_name": "L1",
    "doors": {"front": {"x": 0.0, "y": 0.8, "width": 1.0, "motion_axis_orientation": 0.0}},
    "level_doors": {"L1": ["front"], "L2": ["front"]},
}  # fmt: skip


def building(**members: Any) -> bytes:
    """Return a building of two floors, of which the upper is drawn 30 pixels to the right and 10 down."""
    levels = {"L1": floor(), "L2": floor(dx=30.0, dy=10.0, elevation=4.0)}
    tree = {"name": "inn", "levels": levels, "lifts": {"north": LIFT}}
    return yaml.safe_dump(tree | members, sort_keys=False).encode()
