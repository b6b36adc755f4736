"""Kernels of the sensor models against their twins, and rays through the map."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.kernel_threads import limit_threads
from ppaas.localization.kernels import beam_model, likelihood_field, sight
from ppaas.maps.grid import GridInfo
from tests.reference.driving import localization as twin
from tests.support.budget import examples
from tests.support.world.scattered_walls import distances

seeds = st.integers(0, 2**32 - 1)


@settings(max_examples=examples(25))
@given(seeds, st.floats(-math.pi, math.pi))
def test_range_scores_agree_with_the_twin(seed, yaw):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, yaw))
    distance = distances(seed, info)
    particles = rng.uniform(-2, 3, (8, 3))
    beams = np.column_stack([rng.uniform(-0.2, 0.2, (10, 2)), rng.uniform(-3, 3, 10), rng.uniform(0.1, 3.0, 10)])
    beams[:3, 3] = 3.0
    # A wide hit and a low weight of short ranges, so that half a cell makes little difference.
    shares = beam_model.BeamShares(0.9, 0.01, 0.05, 0.05, 0.5, 0.1)
    expected = twin.score_ranges(particles, beams, distance, info, shares, 3.0)
    found = beam_model.score_serial(particles, beams, distance, info.resolution, np.array(info.origin), shares, 3.0)
    np.testing.assert_allclose(found, expected, atol=10 * 3 * 0.9**3 * 0.1)
    assert np.median(np.abs(found - expected)) < 0.5


@pytest.mark.parametrize("threads", [2, 3])
def test_parallel_scores_are_bitwise_equal_to_serial(threads):
    rng = np.random.default_rng(5)
    distance, origin = distances(5, GridInfo(0.1, 30, 20)), np.zeros(3)
    particles = rng.uniform(-1, 3, (1000, 3))
    rays = np.column_stack([np.zeros((31, 2)), rng.uniform(-3, 3, 31), rng.uniform(0.1, 3.0, 31)])
    shares = beam_model.BeamShares(0.95, 0.1, 0.05, 0.05, 0.2, 0.1)
    with limit_threads(threads):
        ranges = beam_model.score_parallel(particles, rays, distance, 0.1, origin, shares, 3.0)
    np.testing.assert_array_equal(ranges, beam_model.score_serial(particles, rays, distance, 0.1, origin, shares, 3.0))


def cubes(resolution):
    likelihoods = likelihood_field.likelihoods(resolution, 0.95, 0.01, 0.2, 2.0)
    return np.rint(likelihoods**3 * likelihood_field.ONE).astype(np.int64)


@given(seeds, st.floats(-math.pi, math.pi))
def test_scan_scores_agree_with_the_twin(seed, yaw):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, yaw))
    squares = rng.integers(0, 900, info.shape)
    distance = (info.resolution * np.sqrt(squares)).astype(np.float32)
    particles = rng.uniform(-2, 3, (8, 3))
    beams = rng.uniform(-2, 2, (10, 2))
    expected = twin.score_scan(particles, beams, distance, info, 0.95, 0.01, 0.2, 2.0)
    found = likelihood_field.score_serial(
        particles, beams, distance, info.resolution, np.array(info.origin), cubes(info.resolution)
    )
    # A beam that ends within rounding of the edge of a cell may be looked up in its neighbour.
    assert np.mean(np.isclose(found, expected, atol=1e-9)) >= 0.8


def test_particle_whose_beams_end_on_the_wall_scores_higher():
    distance = np.abs(np.arange(100) * 0.05 - 4.0)[None].repeat(100, 0).astype(np.float32)
    beams = np.array([[2.0, 0.0], [2.0, 0.5], [2.0, -0.5]])
    on, beside = likelihood_field.score_serial(
        np.array([[2.0, 2.5, 0.0], [1.5, 2.5, 0.0]]), beams, distance, 0.05, np.zeros(3), cubes(0.05)
    )
    assert 0.0 <= beside < 1.0
    assert on > 2.0


@pytest.mark.parametrize("threads", [2, 3])
def test_parallel_scores_of_the_likelihood_field_are_bitwise_equal_to_serial(threads):
    rng = np.random.default_rng(5)
    distance, origin = distances(5, GridInfo(0.1, 30, 20)), np.zeros(3)
    particles, beams = rng.uniform(-1, 3, (1000, 3)), rng.uniform(-2, 2, (31, 2))
    with limit_threads(threads):
        fields = likelihood_field.score_parallel(particles, beams, distance, 0.1, origin, cubes(0.1))
    one = likelihood_field.score_serial(particles, beams, distance, 0.1, origin, cubes(0.1))
    np.testing.assert_array_equal(fields, one)


def test_likelihood_table_is_bounded_and_ends_with_the_far_value():
    table = likelihood_field.likelihoods(0.05, 0.95, 0.1, 1e9, 1e12)
    assert len(table) <= likelihood_field.MOST_SQUARES + 1
    assert likelihood_field.likelihoods(0.05, 0.95, 0.1, 0.2, 1e12)[-1] == pytest.approx(0.1)


few = settings(max_examples=examples(10))
"""Each example has 400 rays, which take the twins a tenth of a second."""


@few
@given(seeds, st.floats(-math.pi, math.pi))
def test_explained_rays_agree_with_the_twin_except_at_corners(seed, yaw):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, yaw))
    distance = distances(seed, info)
    centre = info.origin @ Pose2D(1.5, 1.0)
    poses = np.array(centre) + rng.uniform(-1.0, 1.0, (20, 3))
    rays = np.hstack((rng.uniform(-1.2, 1.2, (20, 2)), rng.uniform(-0.4, 0.4, (20, 2))))
    found, expected = np.empty((20, 20)), np.empty((20, 20))
    for i, pose in enumerate(poses):
        for j, ray in enumerate(rays):
            explained = sight.explain_rays(pose[None], ray[None], distance, 0.1, np.array(info.origin), 0.1, 0.5)
            found[i, j], expected[i, j] = explained[0], twin.explain_rays(pose, ray, distance, info, 0.1, 0.5)
    same = np.isclose(found, expected, atol=1e-6)
    assert same.mean() > 0.95
    # Steps of half a cell may skip a corner; hardly any free ray is taken to be blocked.
    assert (found < expected - 1e-6).mean() < 0.01
    sums = sight.explain_rays(poses, rays, distance, 0.1, np.array(info.origin), 0.1, 0.5)
    np.testing.assert_allclose(sums, found.sum(axis=1))


@few
@given(seeds, st.floats(-math.pi, math.pi), st.floats(0.3, 5.0))
def test_distances_to_walls_agree_with_the_twin_except_at_corners(seed, yaw, most):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, yaw))
    distance = distances(seed, info)
    lasers = np.array(info.origin @ Pose2D(1.5, 1.0)) + rng.uniform(-1.0, 1.0, (20, 3))
    angles, placed = rng.uniform(-math.pi, math.pi, 20), np.array(info.origin)
    found = np.array([sight.to_walls(laser, angles, distance, 0.1, placed, most) for laser in lasers])
    twins = np.array([[twin.to_walls(laser, angle, distance, info, most) for angle in angles] for laser in lasers])
    assert (np.abs(np.minimum(found, most) - np.minimum(twins, most)) < 0.06).mean() > 0.9


@few
@given(seeds, st.floats(-math.pi, math.pi), st.floats(0.0, 0.5))
def test_stopped_short_agrees_with_the_twin_except_at_corners(seed, yaw, beyond):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, yaw))
    distance = distances(seed, info)
    poses = np.array(info.origin @ Pose2D(1.5, 1.0)) + rng.uniform(-1.0, 1.0, (20, 3))
    points = rng.uniform(-1.2, 1.2, (20, 2))
    placed = np.array(info.origin)
    found = np.array([sight.stopped_short(pose, points, distance, 0.1, placed, beyond) for pose in poses])
    twins = [[twin.stopped_short(pose, point, distance, info, beyond) for point in points] for pose in poses]
    assert (found == twins).mean() > 0.9
    assert (~found & twins).mean() < 0.02
