"""Docks, and how robots stand at them."""

import math

import pytest

from ppaas.docking.dock import DockStance, MappedDock, docks_of
from ppaas.geometry import Pose2D
from ppaas.zones.reading import zones_of

ZONES = b"""{"type": "FeatureCollection", "features": [
    {"type": "Feature", "properties": {"name": "a", "kind": "dock", "yaw": 1.5, "dock_type": "v_shape"},
     "geometry": {"type": "Point", "coordinates": [1.0, 2.0]}},
    {"type": "Feature", "properties": {"name": "s", "kind": "station"},
     "geometry": {"type": "Point", "coordinates": [3.0, 2.0]}},
    {"type": "Feature", "properties": {"name": "cart", "kind": "dock", "yaw": 0.0, "charges": false},
     "geometry": {"type": "Point", "coordinates": [4.0, 2.0]}}
]}"""


def test_docks_are_drawn_on_the_map() -> None:
    assert docks_of(zones_of(ZONES)) == (
        MappedDock("a", Pose2D(1.0, 2.0, 1.5), "v_shape", True), MappedDock("cart", Pose2D(4.0, 2.0, 0.0), "", False),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("stance", "face"),
    [
        (DockStance(0.2), Pose2D(1.0, 1.2, 0.5 * math.pi)),
        (DockStance(0.3, backward=True), Pose2D(1.0, 0.7, -0.5 * math.pi)),
        (DockStance(-0.1), Pose2D(1.0, 0.9, 0.5 * math.pi)),
    ],
)
def test_the_face_is_before_the_robot_or_behind_it(stance: DockStance, face: Pose2D) -> None:
    docked = Pose2D(1.0, 1.0, 0.5 * math.pi)
    assert stance.face_of(docked) == pytest.approx(face)
    assert stance.docked_at(stance.face_of(docked)) == pytest.approx(docked)


def test_a_dock_is_named_or_placed() -> None:
    assert MappedDock("a", Pose2D(1.0, 2.0)).in_words == "dock 'a'"
    assert MappedDock("", Pose2D(1.0, 2.0)).in_words == "the dock at (1.00, 2.00)"
