import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.mapping.scan_points import prepare
from tests.reference.mapping import scans
from tests.support.budget import examples
from tests.support.world.room_scans import ALL_ROUND, CORRIDOR, LASER, PARAMETERS, ranges_at

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
    points, normals, valid = scans.prepare(ranges, laser, PARAMETERS, velocity)
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
