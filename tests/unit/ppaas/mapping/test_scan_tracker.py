import importlib
import pkgutil

import numpy as np
import pytest

import ppaas.mapping.closures.kernels
import ppaas.mapping.graph.kernels
import ppaas.mapping.kernels
from benchmarks.mapping.small_worlds import ring_drive
from ppaas.errors import InvalidParameter, QuotaExceeded
from ppaas.geometry import Pose2D
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.parameters import SlamParameters
from ppaas.mapping.pipeline.offline import map_log
from ppaas.mapping.scan_tracker import ScanTracker
from ppaas.parameters import read_parameters
from tests.support.world.room_scans import CORRIDOR, LASER, PARAMETERS, ROOM, scan_at, segments

MOUNTED = LaserGeometry(LASER.angle_min, LASER.angle_increment, LASER.beams, Pose2D(0.2, -0.1, 0.3))


def route(count=60):
    """Return poses of a robot that drives an arc."""
    part = np.linspace(0.0, 1.0, count)
    return np.column_stack((3.0 * part - 1.5, 0.5 * np.sin(4.0 * part), np.arctan2(2.0 * np.cos(4.0 * part), 3.0)))


def drive(tracker, robots, odometry, laser=LASER, walls=ROOM):
    tracked = []
    for number, (robot, told) in enumerate(zip(robots, odometry, strict=True)):
        at = Pose2D(*robot) @ laser.mount
        tracked.append(tracker.add(scan_at(at, laser, walls, 0.005, number), Pose2D(*told)))
    return tracked


@pytest.mark.parametrize("laser", [LASER, MOUNTED])
def test_pose_is_that_of_the_laser_although_the_odometry_drifts(laser):
    robots = route()
    odometry = robots * (1.05, 1.0, 1.0) + np.linspace(0.0, 0.3, len(robots))[:, None] * (0.0, 0.0, 1.0)
    odometry -= odometry[0] - robots[0]
    tracker = ScanTracker(laser, PARAMETERS)
    tracked = drive(tracker, robots, odometry, laser)
    true = np.array([Pose2D(*robot) @ laser.mount for robot in robots])
    assert np.abs(np.array([found.pose for found in tracked]) - true).max() < 0.02
    assert all(found.ratio > 0.6 for found in tracked)


def test_key_frames_follow_motion_and_are_numbered_by_scan():
    robots = route()
    tracker = ScanTracker(LASER, PARAMETERS)
    tracked = drive(tracker, robots, robots)
    keys = [number for number, found in enumerate(tracked) if found.is_key]
    np.testing.assert_array_equal(tracker.key_frames.scans, keys)
    assert keys[0] == 0
    np.testing.assert_array_equal([found.key_frame for found in tracked], np.cumsum([f.is_key for f in tracked]) - 1)
    steps = np.hypot(*np.diff(tracker.key_frames.poses[:, :2], axis=0).T)
    turns = np.abs(np.diff(tracker.key_frames.poses[:, 2]))
    assert ((steps >= PARAMETERS.minimum_travel_distance) | (turns >= PARAMETERS.minimum_travel_heading)).all()
    assert (tracker.key_frames.information[0] == 0.0).all()
    assert (tracker.key_frames.information[1:, [0, 3, 5]] > 0.0).all()


@pytest.mark.parametrize("slip", [(0.06, 0.0, 0.0), (-0.7, 0.3, 0.0), (0.3, -0.2, 0.5)])
def test_slip_is_followed(slip):
    tracker = ScanTracker(LASER, PARAMETERS)
    robots = route()
    odometry = robots.copy()
    odometry[30:] = [Pose2D(*robot) @ Pose2D(*slip) for robot in robots[30:]]
    assert np.abs(np.array([found.pose for found in drive(tracker, robots, odometry)]) - robots).max() < 0.03


def test_scan_that_fits_nowhere_keeps_the_pose_of_the_odometry():
    tracker = ScanTracker(LASER, PARAMETERS)
    robots = route()
    drive(tracker, robots[:30], robots[:30])
    other = scan_at((0.0, 0.0, 0.0), walls=segments([(-0.5, -0.5), (0.4, -0.6), (0.2, 0.7)]))
    found = tracker.add(other, Pose2D(*robots[30]))
    assert found.ratio < 0.4
    np.testing.assert_allclose(found.pose, robots[30], atol=0.05)


def test_odometry_holds_the_pose_along_a_corridor():
    robots = np.column_stack((np.linspace(0.0, 3.0, 60), np.zeros(60), np.zeros(60)))
    tracker = ScanTracker(LASER, PARAMETERS)
    tracked = drive(tracker, robots, robots, walls=CORRIDOR)
    assert np.abs(np.array([found.pose for found in tracked]) - robots).max() < 0.1


def test_heading_is_kept_along_a_corridor_although_the_odometry_turns():
    robots = np.column_stack((np.linspace(0.0, 10.0, 100), np.zeros(100), np.zeros(100)))
    odometry = robots + np.linspace(0.0, 0.2, 100)[:, None] * (0.0, 0.0, 1.0)
    tracked = drive(ScanTracker(LASER, PARAMETERS), robots, odometry, walls=CORRIDOR)
    assert max(abs(found.pose.theta) for found in tracked) < 0.002
    assert max(abs(found.pose.y) for found in tracked) < 0.02


def test_correction_moves_later_key_frames_and_the_current_pose():
    tracker = ScanTracker(LASER, PARAMETERS)
    robots = route()
    drive(tracker, robots[:40], robots[:40])
    before, count = tracker.key_frames.poses.copy(), len(tracker.key_frames) - 2
    moved = Pose2D(2.0, 1.0, 0.5)
    tracker.correct(np.array([moved @ Pose2D(*pose) for pose in before[:count].tolist()]))
    expected = np.array([moved @ Pose2D(*pose) for pose in before.tolist()])
    np.testing.assert_allclose(tracker.key_frames.poses, expected, atol=1e-9)
    found = tracker.add(scan_at(robots[40]), Pose2D(*robots[40]))
    assert found.pose == pytest.approx(moved @ Pose2D(*robots[40]), abs=0.02)


def test_key_frames_beyond_the_limit_are_refused():
    tracker = ScanTracker(LASER, SlamParameters(max_key_frames=2))
    with pytest.raises(QuotaExceeded, match="2 key frames"):
        drive(tracker, route(), route())


def test_names_of_slam_toolbox_and_gmapping_are_read():
    given = {"minimum_travel_distance": 0.5, "scan_buffer_size": 10, "srr": 0.2, "str": 0.3}
    parameters = read_parameters(SlamParameters, "grid_slam", given)
    assert (parameters.minimum_travel_distance, parameters.scan_buffer_size) == (0.5, 10)
    assert (parameters.srr, parameters.str) == (0.2, 0.3)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"resolution": 0.0}, "resolution must be above 0"),
        ({"srt": -0.1}, "srt must be at least 0"),
        ({"max_laser_range": 0.01}, "below max_laser_range"),
        ({"scan_buffer_size": 65}, "at most 64"),
        ({"no_such": 1}, "no_such"),
    ],
)
def test_parameters_out_of_range_are_refused(given, text):
    with pytest.raises(InvalidParameter, match=text):
        read_parameters(SlamParameters, "grid_slam", given)


PACKAGES = (ppaas.mapping.kernels, ppaas.mapping.graph.kernels, ppaas.mapping.closures.kernels)


def modules():
    for package in PACKAGES:
        for found in pkgutil.iter_modules(package.__path__, f"{package.__name__}."):
            yield importlib.import_module(found.name)


def signatures():
    return {
        (module.__name__, name): list(kernel.signatures)
        for module in modules()
        for name, kernel in vars(module).items()
        if hasattr(kernel, "py_func") and kernel.py_func.__module__ == module.__name__
    }


def test_mapping_uses_no_kernel_that_warm_has_not_compiled():
    for module in modules():
        if hasattr(module, "warm"):
            module.warm()
    warm = signatures()
    made = map_log(ring_drive().log)
    made.grid()
    assert made.mapper.counts.closures > 0
    assert signatures() == warm
