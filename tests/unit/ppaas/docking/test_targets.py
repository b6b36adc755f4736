"""Docks of goals with the settings of their types."""

import pytest

from ppaas.docking.approach import BodyOutline
from ppaas.docking.dock import MappedDock
from ppaas.docking.failures import DockTypeUnknown, DockUnknown
from ppaas.docking.parameters import DockingParameters, DockType
from ppaas.docking.targets import DockTargets
from ppaas.errors import InvalidParameter, NotFound
from ppaas.geometry import Pose2D

BODY = BodyOutline(0.25, 0.3, 0.2)
DOCKS = [
    MappedDock("far", Pose2D(9.0, 0.0)),
    MappedDock("near", Pose2D(1.0, 0.0, 0.0)),
    MappedDock("v", Pose2D(5.0, 0.0)),
]


def targets(**parameters: object) -> DockTargets:
    return DockTargets(DockingParameters(**parameters), BODY)  # type: ignore[arg-type]


def test_a_robot_stands_before_the_face_by_its_own_extent() -> None:
    forward, backward = DockType(), DockType(dock_direction="backward", staging_distance=1.0)
    made = targets(dock_types={"front": forward, "rear": backward})
    front = made.target(MappedDock("a", Pose2D(2.0, 0.0, 0.0), "front"))
    rear = made.target(MappedDock("b", Pose2D(2.0, 0.0, 0.0), "rear"))
    assert (front.stance.distance, rear.stance.distance) == (0.25, 0.3)
    assert front.staging == pytest.approx((1.3, 0.0, 0.0))
    assert rear.staging == pytest.approx((3.0, 0.0, 0.0))


def test_a_type_is_that_of_the_robot_or_a_detector() -> None:
    only = targets(dock_types={"home": DockType(detection="v_shape")})
    assert only.target(MappedDock("a", Pose2D(0, 0))).detector.name == "v_shape"
    assert only.target(MappedDock("a", Pose2D(0, 0), "reflectors")).detector.name == "reflectors"
    assert targets().target(MappedDock("a", Pose2D(0, 0))).detector.name == "scan_line"
    two = targets(dock_types={"home": DockType(), "cart": DockType(detection="legs")})
    with pytest.raises(DockTypeUnknown, match="name a dock_type: the robot has settings for cart, home"):
        two.target(MappedDock("a", Pose2D(0, 0)))
    with pytest.raises(DockTypeUnknown, match=r"no dock_type 'rocket'; known: .*cart, home.*scan_line"):
        two.target(MappedDock("a", Pose2D(0, 0), "rocket"))


def test_wrong_detectors_are_refused_by_name() -> None:
    with pytest.raises(NotFound, match="sonar"):
        targets(dock_types={"home": DockType(detection="sonar")})
    with pytest.raises(InvalidParameter, match="has no parameter 'length'"):
        targets(dock_types={"home": DockType(detector={"length": 1.0})})
    with pytest.raises(InvalidParameter, match="must be above 0 m"):
        targets(dock_types={"home": DockType(detector={"width": 0.0})})


def test_docks_are_tried_in_order() -> None:
    made = targets(next_docks={"near": "v", "v": "near"})
    assert [each.dock.name for each in made.named("near", DOCKS, None)] == ["near", "v"]
    assert [each.dock.name for each in made.named("far", DOCKS, None)] == ["far"]
    assert [each.dock.name for each in made.named("", DOCKS, Pose2D(4.0, 0.0))] == ["v", "near", "far"]
    with pytest.raises(DockUnknown, match="no dock 'nowhere'; its docks: far, near, v"):
        made.named("nowhere", DOCKS, None)
    with pytest.raises(DockUnknown, match="the map has no docks: draw zones of the kind 'dock'"):
        made.named("near", [], None)
