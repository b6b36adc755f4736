import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.mapping.kernels import alignment as kernels
from ppaas.mapping.kernels.pose import relative, solve
from ppaas.mapping.laser_geometry import LaserGeometry
from ppaas.planar_poses import relative as relative_poses
from tests.reference.mapping import scans
from tests.support.budget import examples
from tests.support.world.room_scans import ALL_ROUND, CORRIDOR, LASER, scan_at

seeds = st.integers(0, 2**32 - 1)
HALF_AND_MORE = LaserGeometry(2.0, math.radians(0.5), 500)


def sums_of(scan, frame, apart, laser, gate=0.3, scale=0.05, side=30):
    sums = np.zeros(9)
    found = kernels.add_pairs(
        *scan, frame.points, frame.normals, apart, laser.angle_min, laser.beams_per_radian, laser.beams_per_turn,
        gate, scale, side, sums,
    )  # fmt: skip
    return sums, found


@given(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_bearings_are_exact_to_four_milliradians(x, y):
    if math.hypot(x, y) > 1e-3:
        off = kernels.bearing(x, y) - math.atan2(y, x)
        assert abs((off + math.pi) % (2.0 * math.pi) - math.pi) < 4.1e-3


@pytest.mark.parametrize("laser", [LASER, ALL_ROUND, HALF_AND_MORE, LaserGeometry(1.5, -0.0125, 240)])
@settings(max_examples=examples(10))
@given(seeds)
def test_normal_equations_agree_with_the_twin(laser, seed):
    rng = np.random.default_rng(seed)
    at, other = rng.uniform((-2.0, -2.0, -3.0), (2.0, 1.0, 3.0)), rng.uniform(-0.2, 0.2, 3)
    frame, scan = scan_at(at, laser, noise=0.01), scan_at(at + other, laser, noise=0.01, seed=1)
    apart = relative_poses(at, at + other) + rng.uniform(-0.02, 0.02, 3)
    sums, (pairs, readings, squares) = sums_of(scan, frame, apart, laser)
    increment = abs(laser.angle_increment)
    information, gradient, count, square = scans.normal_equations(scan, frame, apart, 0.3, 0.05, increment)
    assert readings == scan.valid.sum()
    # A window of 30 beams may miss the nearest point of surfaces that are close to the laser.
    assert abs(pairs - count) <= 0.03 * count + 2
    scale = np.abs(information).max()
    np.testing.assert_allclose(sums[:6], information[np.triu_indices(3)], atol=0.05 * scale)
    np.testing.assert_allclose(sums[6:], gradient, atol=0.02 * scale * 0.05 + 0.02)
    assert squares == pytest.approx(square, rel=0.2, abs=0.01)


def test_point_between_two_points_of_a_glancing_wall_belongs_to_its_line():
    frame = scan_at((0.0, 0.0, 0.0), walls=CORRIDOR)
    beam = int(np.flatnonzero(frame.points[:, 0] > 8.0)[0])
    middle = 0.5 * (frame.points[beam] + frame.points[beam - 1])
    settings = (0.1, LASER.angle_min, LASER.beams_per_radian, LASER.beams_per_turn, 8, frame.points, frame.normals)
    assert np.hypot(*(frame.points[beam] - frame.points[beam - 1])) > 0.5
    assert kernels.associate(*middle, *settings) in (beam, beam - 1)
    assert kernels.associate(middle[0], middle[1] + 0.12, *settings) == -1


@given(seeds)
def test_step_of_the_normal_equations_is_that_of_numpy(seed):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((5, 3))
    information, gradient = root.T @ root + 0.1 * np.eye(3), rng.standard_normal(3)
    found = solve(np.concatenate((information[np.triu_indices(3)], gradient)))
    np.testing.assert_allclose(found, np.linalg.solve(information, gradient), rtol=1e-6, atol=1e-9)


@given(seeds)
def test_relative_pose_is_that_of_arrays(seed):
    a, b = np.random.default_rng(seed).uniform(-3.0, 3.0, (2, 3))
    found = np.empty(3)
    relative(a, b, found)
    np.testing.assert_allclose(found, relative_poses(a, b), atol=1e-12)


def test_linearised_pairs_are_those_of_single_pairs():
    poses = np.array([(0.0, 0.0, 0.0), (0.2, 0.1, 0.1), (-0.3, 0.2, -0.2)])
    scans = [scan_at(pose, noise=0.005) for pose in poses]
    points, normals, valid = (np.array(parts) for parts in zip(*scans, strict=True))
    first, second = np.array([0, 2, 1]), np.array([1, 0, 2])
    apart = relative_poses(poses[first], poses[second])
    sums, counts, squares = kernels.linearise(
        first, second, apart, points, normals, valid,
        LASER.angle_min, LASER.beams_per_radian, LASER.beams_per_turn, 0.3, 0.05, 8,
    )  # fmt: skip
    for m in range(3):
        expected, found = sums_of(scans[second[m]], scans[first[m]], apart[m], LASER, side=8)
        np.testing.assert_allclose(sums[m], expected)
        assert (*counts[m], squares[m]) == found


def test_gradient_and_information_are_those_of_a_small_motion():
    frame, scan = scan_at((0.0, 0.0, 0.2)), scan_at((0.1, 0.1, 0.25))
    apart = relative_poses((0.0, 0.0, 0.2), (0.1, 0.1, 0.25)) + np.array((0.01, -0.01, 0.005))
    sums, _ = sums_of(scan, frame, apart, LASER, scale=1e3)
    for axis in range(3):
        ahead, behind = np.zeros(3), np.zeros(3)
        ahead[axis], behind[axis] = 1e-4, -1e-4
        c, s = math.cos(apart[2]), math.sin(apart[2])
        turn = np.array([(c, -s, 0.0), (s, c, 0.0), (0.0, 0.0, 1.0)])
        _, (_, _, more) = sums_of(scan, frame, apart + turn @ ahead, LASER, scale=1e3)
        _, (_, _, less) = sums_of(scan, frame, apart + turn @ behind, LASER, scale=1e3)
        assert 0.5 * (more - less) / 2e-4 == pytest.approx(sums[6 + axis], rel=0.05, abs=0.02)
