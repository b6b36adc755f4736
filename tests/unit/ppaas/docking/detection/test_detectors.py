"""Detectors of docks, in noisy scans of simulated docks."""

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from ppaas.docking.detection.base import DockDetector, DockView
from ppaas.docking.detection.given import AprilTag, MappedPose, PoseOfTopic
from ppaas.docking.detection.lines import clusters, line_through, pieces
from ppaas.docking.detection.pairs import CartLegs, Reflectors
from ppaas.docking.detection.registry import DOCK_DETECTORS
from ppaas.docking.detection.scan_line import ScanLine
from ppaas.docking.detection.v_shape import VShape
from ppaas.errors import InvalidParameter
from ppaas.geometry import Pose2D, quaternion_of, wrap_angle
from ppaas.transforms.spatial import Rigid
from robots.sim.docks.charger import Charger, ChargerModel
from robots.sim.laser import LaserModel, cast_at_discs

ANGLES = LaserModel(beams=720).angles
WALL = [(1.8, y) for y in np.arange(-3.0, 3.0, 0.02)]
NOWHERE = Pose2D(0.0, 0.0)


def scan_of(discs: list[tuple[float, float, float]], robot: Pose2D, noise: float = 0.01, seed: int = 0) -> DockView:
    """Return a scan of discs and a wall behind them, in the frame of a robot; small discs are bright."""
    rows = np.array([*discs, *((x, y, 0.012) for x, y in WALL)])
    ranges, bright = np.full(len(ANGLES), np.inf), np.full(len(ANGLES), 100.0)
    for radius in np.unique(rows[:, 2]).tolist():
        hit = cast_at_discs(robot, ANGLES, np.ascontiguousarray(rows[rows[:, 2] == radius, :2]), radius)
        bright[hit < ranges] = 900.0 if radius == 0.03 else 100.0
        ranges = np.minimum(ranges, hit)
    rng = np.random.default_rng(seed)
    seen = np.isfinite(ranges)
    ranges = ranges[seen] + noise * rng.standard_normal(int(seen.sum()))
    points: NDArray[np.float64] = np.stack((ranges * np.cos(ANGLES[seen]), ranges * np.sin(ANGLES[seen])), axis=1)
    return DockView(points, bright[seen] + 20.0 * rng.standard_normal(int(seen.sum())))


def box(model: ChargerModel, face: Pose2D) -> list[tuple[float, float, float]]:
    return list(Charger(face, 0.0, model).body().discs)


def marks(face: Pose2D, spacing: float, radius: float) -> list[tuple[float, float, float]]:
    places = [face @ Pose2D(0.0, side * 0.5 * spacing) for side in (-1.0, 1.0)]
    return [(place.x, place.y, radius) for place in places]


FACE = Pose2D(1.2, 0.1, 0.2)
CASES = [
    (ScanLine(), box(ChargerModel(), FACE), 0.0),
    (VShape(angle=2.1, arm=0.23), box(ChargerModel(angle=2.1), FACE), 0.01),
    (Reflectors(spacing=0.3), marks(FACE, 0.3, 0.03), -0.03),
    (CartLegs(spacing=0.5), marks(FACE, 0.5, 0.025), -0.025),
]


@pytest.mark.parametrize(("detector", "discs", "nearer"), CASES, ids=[case[0].name for case in CASES])
@pytest.mark.parametrize("robot", [Pose2D(0.3, 0.0, 0.0), Pose2D(0.4, 0.25, -0.3), Pose2D(0.45, -0.2, 0.5)])
def test_a_dock_is_found_in_noise_also_if_it_was_moved_by_20_cm(
    detector: DockDetector, discs: list[tuple[float, float, float]], nearer: float, robot: Pose2D
) -> None:
    true = robot.inverse() @ FACE @ Pose2D(nearer, 0.0)
    errors = []
    for seed in range(10):
        turn = 2.4 * seed
        expected = robot.inverse() @ Pose2D(FACE.x + 0.2 * math.cos(turn), FACE.y + 0.2 * math.sin(turn), FACE.theta)
        face = detector.detect(scan_of(discs, robot, seed=seed), expected)
        if face is not None:
            errors.append((*(true.inverse() @ face)[:2], wrap_angle(face.theta - true.theta)))
    assert len(errors) >= 7, "single scans may show nothing"
    x, y, theta = np.median(errors, axis=0).tolist()
    assert abs(x) < 0.02 and abs(y) < 0.025 and abs(theta) < 0.12


@pytest.mark.parametrize(("detector", "discs", "nearer"), CASES, ids=[case[0].name for case in CASES])
def test_nothing_is_found_where_there_is_only_a_wall_or_a_dock_elsewhere(
    detector: DockDetector, discs: list[tuple[float, float, float]], nearer: float
) -> None:
    robot = Pose2D(0.3, 0.0, 0.0)
    assert detector.detect(scan_of([], robot), robot.inverse() @ FACE) is None
    assert detector.detect(scan_of(discs, robot), robot.inverse() @ FACE @ Pose2D(0.0, 1.0)) is None
    assert detector.detect(DockView(np.empty((0, 2))), FACE) is None


def test_a_laser_without_intensities_shows_no_reflectors() -> None:
    view = scan_of(marks(FACE, 0.3, 0.03), NOWHERE)
    assert Reflectors().detect(DockView(view.points), FACE) is None
    assert Reflectors(intensity=2000.0).detect(view, FACE) is None


def test_poses_of_a_topic_count_near_the_dock() -> None:
    given = Rigid(1.0, 0.1, 0.3, *quaternion_of(0.2))
    face = PoseOfTopic(translation_x=0.1).detect(DockView(np.empty((0, 2)), detected=given), Pose2D(1.1, 0.0))
    assert face == pytest.approx((1.0 + 0.1 * math.cos(0.2), 0.1 + 0.1 * math.sin(0.2), 0.2))
    assert PoseOfTopic().detect(DockView(np.empty((0, 2)), detected=given), Pose2D(3.0, 0.0)) is None
    assert PoseOfTopic().detect(DockView(np.empty((0, 2))), Pose2D(1.0, 0.0)) is None


@pytest.mark.parametrize("q", [(-0.5, 0.5, -0.5, 0.5), (0.5, 0.5, 0.5, 0.5)])
def test_a_tag_faces_the_robot_whichever_way_its_normal_points(q: tuple[float, float, float, float]) -> None:
    tag = DockView(np.empty((0, 2)), detected=Rigid(1.0, 0.1, 0.3, *q))
    assert AprilTag().detect(tag, Pose2D(1.0, 0.0)) == pytest.approx((1.0, 0.1, 0.0))
    flat = DockView(np.empty((0, 2)), detected=Rigid(1.0, 0.1, 0.0))
    assert AprilTag().detect(flat, Pose2D(1.0, 0.0)) is None


def test_the_map_alone_may_say_where_a_dock_is() -> None:
    assert MappedPose().detect(DockView(np.empty((0, 2)), mapped=FACE), NOWHERE) == FACE
    assert MappedPose().detect(DockView(np.empty((0, 2))), NOWHERE) is None


def test_all_detectors_are_plug_ins() -> None:
    assert set(DOCK_DETECTORS.names()) >= {
        "april_tag", "legs", "map", "pose", "reflectors", "scan_line", "v_shape"
    }  # fmt: skip
    for name in DOCK_DETECTORS.names():
        detector = DOCK_DETECTORS.create(name, {})
        assert detector.name == name and detector.purpose


@pytest.mark.parametrize("name", ["scan_line", "v_shape", "reflectors", "legs", "pose", "april_tag"])
def test_numbers_that_mean_nothing_are_refused(name: str) -> None:
    with pytest.raises(InvalidParameter, match=r"must be (above 0|between)"):
        DOCK_DETECTORS.create(name, {"search": 0.0})


def test_clusters_of_a_whole_turn_meet_and_corners_split_them() -> None:
    turn = np.linspace(-np.pi, np.pi, 90, endpoint=False)
    circle = np.stack((np.cos(turn), np.sin(turn)), axis=1)
    assert [len(each) for each in clusters(np.delete(circle, [30, 31], axis=0), 0.1)] == [88]
    corner = np.array([(x, 0.0) for x in np.arange(0.0, 0.5, 0.05)] + [(0.5, y) for y in np.arange(0.0, 0.5, 0.05)])
    lengths = [line_through(each).length for each in pieces(corner, 0.02)]
    assert sorted(lengths) == pytest.approx([0.45, 0.5], abs=0.06)
