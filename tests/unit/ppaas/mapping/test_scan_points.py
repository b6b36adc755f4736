import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_points import prepare, with_open_beams, without_discs
from ppaas.planar_poses import compose
from tests.reference.mapping import scans as twin
from tests.support.budget import examples
from tests.support.world.room_scans import ALL_ROUND, CORRIDOR, LASER, PARAMETERS, ROOM, ranges_at, scan_at


def test_readings_are_finite_and_within_the_limits():
    ranges = np.full(181, 2.0)
    ranges[:6] = np.nan, np.inf, -1.0, 0.0, 0.04, 41.0
    scan = prepare(ranges, LASER, PARAMETERS)
    assert scan.valid.sum() == 175
    assert (scan.points[:6] == 0.0).all()
    np.testing.assert_allclose(np.hypot(*scan.points[6:].T), 2.0, rtol=1e-6)


def test_wrong_number_of_ranges_is_refused():
    with pytest.raises(InvalidInput, match="181 ranges, not 180"):
        prepare(np.ones(180), LASER, PARAMETERS)


def test_scan_of_a_moving_laser_is_corrected_by_its_velocity():
    slow = LaserGeometry(LASER.angle_min, LASER.angle_increment, 181, time_increment=1e-3, stamped_at=0.0)
    speed, turn = 1.0, 0.8
    ranges = np.empty(181)
    for b in range(181):
        late = b * 1e-3
        pose = (speed / turn * np.sin(turn * late), speed / turn * (1.0 - np.cos(turn * late)), turn * late)
        ranges[b] = ranges_at(pose, LASER, ROOM)[b]
    corrected = prepare(ranges, slow, PARAMETERS, (speed, 0.0, turn))
    plain = prepare(ranges, slow, PARAMETERS)
    ahead = (np.abs(corrected.points[:, 1]) < 0.5) & (corrected.points[:, 0] > 3.0)
    assert np.abs(corrected.points[ahead, 0] - 4.0).max() < 0.02
    assert np.abs(plain.points[ahead, 0] - 4.0).max() > 0.05


def test_beams_that_hit_nothing_are_free_up_to_a_range():
    ranges = np.full(181, 2.0)
    ranges[50:60] = np.nan
    scan = prepare(ranges, LASER, PARAMETERS)
    hit_nothing = np.zeros(181, bool)
    hit_nothing[40:55] = True
    found = with_open_beams(scan, hit_nothing, 8.0, LASER)
    assert not found.valid[50:60].any()
    np.testing.assert_array_equal(found.points[:50], scan.points[:50])
    np.testing.assert_allclose(np.hypot(*found.points[50:55].T), 8.0, rtol=1e-6)
    bearings = LASER.angle_min + LASER.angle_increment * np.arange(50, 55)
    np.testing.assert_allclose(np.arctan2(*found.points[50:55, ::-1].T), bearings, rtol=1e-5)
    assert (found.points[55:60] == 0.0).all()


def test_free_beams_of_a_moving_laser_are_where_those_with_readings_would_be():
    slow = LaserGeometry(LASER.angle_min, LASER.angle_increment, 181, time_increment=1e-3, stamped_at=0.3)
    velocity = (1.0, 0.2, 0.8)
    measured = prepare(np.full(181, 8.0), slow, PARAMETERS, velocity)
    none = prepare(np.full(181, np.nan), slow, PARAMETERS, velocity)
    found = with_open_beams(none, np.ones(181, bool), 8.0, slow, velocity)
    np.testing.assert_allclose(found.points, measured.points, atol=1e-5)


POSE = Pose2D(1.0, -0.5, 0.7)


def in_map(scan):
    return compose(np.array(POSE), np.column_stack((scan.points, np.zeros(len(scan.points)))))[:, :2]


@given(x=st.floats(-5.0, 7.0), y=st.floats(-4.0, 4.0), radius=st.floats(0.05, 1.5))
def test_only_points_on_the_disc_lose_their_reading(x, y, radius):
    scan = scan_at(POSE)
    cut = without_discs(scan, POSE, np.array([(x, y, radius)]))
    away = np.hypot(*(in_map(scan) - (x, y)).T)
    clear = np.abs(away - radius) > 1e-5
    np.testing.assert_array_equal(cut.valid[clear], (scan.valid & (away > radius))[clear])
    np.testing.assert_array_equal(cut.points[cut.valid], scan.points[cut.valid])
    assert not cut.normals[~cut.valid].any()


def test_a_scan_without_such_points_is_returned_unchanged():
    scan = scan_at(POSE)
    assert without_discs(scan, POSE, np.empty((0, 3))) is scan
    assert without_discs(scan, POSE, np.array([(30.0, 30.0, 1.0)])) is scan


def test_normals_beside_a_cut_are_dropped():
    scan = scan_at(POSE)
    middle = int(np.flatnonzero(scan.valid)[40])
    x, y = in_map(scan)[middle]
    cut = without_discs(scan, POSE, np.array([(x, y, 0.01)]))
    assert not cut.valid[middle]
    assert cut.valid[[middle - 1, middle + 1]].all()
    assert not cut.normals[[middle - 1, middle, middle + 1]].any()


SLOW = LaserGeometry(-1.5, 0.01, 300, time_increment=3e-4, stamped_at=0.0)
CLOCKWISE = LaserGeometry(1.5, -0.0125, 240)


@pytest.mark.parametrize("laser", [LASER, ALL_ROUND, SLOW, CLOCKWISE])
@settings(max_examples=examples(10))
@given(st.integers(0, 2**32 - 1))
def test_points_and_normals_agree_with_the_twin(laser, seed):
    rng = np.random.default_rng(seed)
    ranges = ranges_at(rng.uniform((-3.0, -2.0, -3.0), (3.0, 1.0, 3.0)), laser, noise=0.01, seed=seed)
    ranges[rng.random(laser.beams) < 0.05] = np.nan
    velocity = rng.uniform(-1.0, 1.0, 3)
    scan = prepare(ranges, laser, PARAMETERS, velocity)
    points, normals, valid = twin.prepare(ranges, laser, PARAMETERS, velocity)
    np.testing.assert_array_equal(scan.valid, valid)
    np.testing.assert_allclose(scan.points, points, atol=1e-5)
    # At the limits of the neighbourhood, rounding may decide whether a point belongs to it.
    assert (np.abs(scan.normals - normals).max(axis=1) < 1e-2).mean() > 0.97


def test_normals_are_of_unit_length_and_face_the_laser():
    scan = prepare(ranges_at((0.5, 0.2, 0.3)), LASER, PARAMETERS)
    lines = np.abs(scan.normals).sum(axis=1) > 0.0
    assert lines.mean() > 0.8
    np.testing.assert_allclose(np.hypot(*scan.normals[lines].T), 1.0, atol=1e-6)
    assert ((scan.points * scan.normals).sum(axis=1)[lines] < 0.0).all()


def test_far_points_of_a_glancing_wall_have_normals():
    scan = prepare(ranges_at((0.0, 0.0, 0.0), walls=CORRIDOR), LASER, PARAMETERS)
    far = (scan.points[:, 0] > 6.0) & (scan.points[:, 0] < 15.0)
    assert far.sum() > 6
    np.testing.assert_allclose(np.abs(scan.normals[far, 1]), 1.0, atol=1e-3)
