"""The kernels of localization do what their twins do."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.costmap.build_layers import build_layers
from ppaas.geometry import Pose2D
from ppaas.kernel_threads import at_most
from ppaas.localization.kernels import beam_model, cluster, free_cells, likelihood_field, motion, resample, sight
from ppaas.localization.parameters import AmclParameters
from ppaas.localization.particle_filter import ParticleFilter
from ppaas.maps.distance import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, GridInfo, GridMap
from tests.reference.driving import localization as twin

seeds = st.integers(0, 2**32 - 1)


MOVES = [
    (motion.move_diff_serial, twin.move_diff),
    (motion.move_diff_parallel, twin.move_diff),
    (motion.move_omni_serial, twin.move_omni),
    (motion.move_omni_parallel, twin.move_omni),
]


@pytest.mark.parametrize(("move", "slow"), MOVES)
@settings(deadline=None)
@given(seeds, st.floats(-math.pi, math.pi), st.floats(0, 3), st.floats(-math.pi, math.pi))
def test_motion_moves_as_its_twin(move, slow, seed, first, second, third):
    rng = np.random.default_rng(seed)
    particles = rng.uniform(-5, 5, (20, 3))
    sigmas, normals = tuple(rng.uniform(0, 0.5, 3)), rng.standard_normal((20, 3))
    expected = slow(particles, (first, second, third), sigmas, normals)
    move(particles, (first, second, third), sigmas, normals)
    np.testing.assert_allclose(particles[:, :2], expected[:, :2], atol=1e-9)
    turned = (particles[:, 2] - expected[:, 2] + math.pi) % (2 * math.pi) - math.pi
    np.testing.assert_allclose(turned, 0.0, atol=1e-9)


def test_without_noise_a_motion_is_exact():
    particles = np.array([[1.0, 2.0, math.pi / 2]])
    motion.move_diff_serial(particles, (math.pi / 2, 3.0, -math.pi / 2), (0.0, 0.0, 0.0), np.ones((1, 3)))
    np.testing.assert_allclose(particles, [[-2.0, 2.0, math.pi / 2]], atol=1e-12)


def cubes(resolution):
    likelihoods = likelihood_field.likelihoods(resolution, 0.95, 0.01, 0.2, 2.0)
    return np.rint(likelihoods**3 * likelihood_field.ONE).astype(np.int64)


@settings(deadline=None)
@given(seeds, st.floats(-math.pi, math.pi))
def test_scans_are_scored_as_by_their_twin(seed, turned):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, turned))
    squares = rng.integers(0, 900, info.shape)
    distance = (info.resolution * np.sqrt(squares)).astype(np.float32)
    particles = rng.uniform(-2, 3, (8, 3))
    beams = rng.uniform(-2, 2, (10, 2))
    expected = twin.score_scan(particles, beams, distance, info, 0.95, 0.01, 0.2, 2.0)
    found = likelihood_field.score_serial(
        particles, beams, distance, info.resolution, np.array(info.origin), cubes(info.resolution)
    )
    # A beam that ends within rounding of the edge of a cell may be read off its neighbour.
    assert np.mean(np.isclose(found, expected, atol=1e-9)) >= 0.8


def test_a_particle_whose_beams_end_on_the_wall_outscores_one_beside():
    distance = np.abs(np.arange(100) * 0.05 - 4.0)[None].repeat(100, 0).astype(np.float32)
    beams = np.array([[2.0, 0.0], [2.0, 0.5], [2.0, -0.5]])
    on, beside = likelihood_field.score_serial(
        np.array([[2.0, 2.5, 0.0], [1.5, 2.5, 0.0]]), beams, distance, 0.05, np.zeros(3), cubes(0.05)
    )
    assert 0.0 <= beside < 1.0
    assert on > 2.0


def walls(seed, info):
    """Some occupied cells, and how far each cell is from them."""
    data = np.where(np.random.default_rng(seed).random(info.shape) < 0.05, OCCUPIED, FREE).astype(np.int8)
    data[0, 0] = OCCUPIED
    return distance_to_occupied(GridMap(data, info))


@settings(deadline=None, max_examples=25)
@given(seeds, st.floats(-math.pi, math.pi))
def test_ranges_are_scored_as_by_their_twin(seed, turned):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, turned))
    distance = walls(seed, info)
    particles = rng.uniform(-2, 3, (8, 3))
    beams = np.column_stack([rng.uniform(-0.2, 0.2, (10, 2)), rng.uniform(-3, 3, 10), rng.uniform(0.1, 3.0, 10)])
    beams[:3, 3] = 3.0
    # A wide hit and few of the short ones: half a cell more or less is no great difference.
    shares = beam_model.BeamShares(0.9, 0.01, 0.05, 0.05, 0.5, 0.1)
    expected = twin.score_ranges(particles, beams, distance, info, shares, 3.0)
    found = beam_model.score_serial(particles, beams, distance, info.resolution, np.array(info.origin), shares, 3.0)
    np.testing.assert_allclose(found, expected, atol=10 * 3 * 0.9**3 * 0.1)
    assert np.median(np.abs(found - expected)) < 0.5


@settings(deadline=None)
@given(seeds, st.floats(-math.pi, math.pi))
def test_rays_are_accounted_for_as_by_their_twin_but_for_those_that_graze_a_corner(seed, turned):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, turned))
    distance = walls(seed, info)
    centre = info.origin @ Pose2D(1.5, 1.0)
    poses = np.array(centre) + rng.uniform(-1.0, 1.0, (20, 3))
    rays = np.hstack((rng.uniform(-1.2, 1.2, (20, 2)), rng.uniform(-0.4, 0.4, (20, 2))))
    found, expected = np.empty((20, 20)), np.empty((20, 20))
    for i, pose in enumerate(poses):
        for j, ray in enumerate(rays):
            told = sight.account_for(pose[None], ray[None], distance, 0.1, np.array(info.origin), 0.1, 0.5)
            found[i, j], expected[i, j] = told[0], twin.account_for(pose, ray, distance, info, 0.1, 0.5)
    same = np.isclose(found, expected, atol=1e-6)
    assert same.mean() > 0.95
    # A corner that half a cell steps over is taken for open; hardly anything that is open is taken for shut.
    assert (found < expected - 1e-6).mean() < 0.01
    sums = sight.account_for(poses, rays, distance, 0.1, np.array(info.origin), 0.1, 0.5)
    np.testing.assert_allclose(sums, found.sum(axis=1))


@settings(deadline=None)
@given(seeds, st.floats(-math.pi, math.pi), st.floats(0.3, 5.0))
def test_beams_go_to_walls_as_by_their_twin_but_for_those_that_graze_a_corner(seed, turned, most):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, turned))
    distance = walls(seed, info)
    lasers = np.array(info.origin @ Pose2D(1.5, 1.0)) + rng.uniform(-1.0, 1.0, (20, 3))
    angles, placed = rng.uniform(-math.pi, math.pi, 20), np.array(info.origin)
    found = np.array([sight.to_walls(laser, angles, distance, 0.1, placed, most) for laser in lasers])
    twins = np.array([[twin.to_walls(laser, angle, distance, info, most) for angle in angles] for laser in lasers])
    assert (np.abs(np.minimum(found, most) - np.minimum(twins, most)) < 0.06).mean() > 0.9


@settings(deadline=None)
@given(seeds, st.floats(-math.pi, math.pi), st.floats(0.0, 0.5))
def test_beams_stop_short_as_by_their_twin_but_for_those_that_graze_a_corner(seed, turned, beyond):
    rng = np.random.default_rng(seed)
    info = GridInfo(0.1, 30, 20, Pose2D(-1.0, 0.5, turned))
    distance = walls(seed, info)
    poses = np.array(info.origin @ Pose2D(1.5, 1.0)) + rng.uniform(-1.0, 1.0, (20, 3))
    points = rng.uniform(-1.2, 1.2, (20, 2))
    placed = np.array(info.origin)
    found = np.array([sight.stopped_short(pose, points, distance, 0.1, placed, beyond) for pose in poses])
    twins = [[twin.stopped_short(pose, point, distance, info, beyond) for point in points] for pose in poses]
    assert (found == twins).mean() > 0.9
    assert (~found & twins).mean() < 0.02


@pytest.mark.parametrize("threads", [2, 3])
def test_any_number_of_threads_scores_the_same_to_the_last_bit(threads):
    rng = np.random.default_rng(5)
    info = GridInfo(0.1, 30, 20)
    distance, origin = walls(5, info), np.zeros(3)
    particles, beams = rng.uniform(-1, 3, (1000, 3)), rng.uniform(-2, 2, (31, 2))
    rays = np.column_stack([np.zeros((31, 2)), rng.uniform(-3, 3, 31), rng.uniform(0.1, 3.0, 31)])
    shares = beam_model.BeamShares(0.95, 0.1, 0.05, 0.05, 0.2, 0.1)
    with at_most(threads):
        fields = likelihood_field.score_parallel(particles, beams, distance, 0.1, origin, cubes(0.1))
        ranges = beam_model.score_parallel(particles, rays, distance, 0.1, origin, shares, 3.0)
    one = likelihood_field.score_serial(particles, beams, distance, 0.1, origin, cubes(0.1))
    np.testing.assert_array_equal(fields, one)
    np.testing.assert_array_equal(ranges, beam_model.score_serial(particles, rays, distance, 0.1, origin, shares, 3.0))


def test_the_table_of_likelihoods_is_bounded_whatever_the_parameters_and_ends_with_what_is_far():
    table = likelihood_field.likelihoods(0.05, 0.95, 0.1, 1e9, 1e12)
    assert len(table) <= likelihood_field.MOST_SQUARES + 1
    assert likelihood_field.likelihoods(0.05, 0.95, 0.1, 0.2, 1e12)[-1] == pytest.approx(0.1)


@settings(deadline=None)
@given(seeds, st.floats(-4, 4))
def test_what_is_around_a_pose_is_that_of_its_twin(seed, theta):
    rng = np.random.default_rng(seed)
    particles = rng.normal((1.0, 2.0, theta), (0.6, 0.6, 0.7), (50, 3))
    particles[0] = 1.0, 2.0, theta
    weights = rng.uniform(0.1, 1.0, 50)
    total, mean, covariance = cluster.moments_around(particles, weights, Pose2D(1.0, 2.0, theta), 0.75, 0.8)
    expected = twin.moments_around(particles, weights, Pose2D(1.0, 2.0, theta), 0.75, 0.8)
    assert total == pytest.approx(expected[0])
    assert mean[:2] == pytest.approx(expected[1][:2])
    assert math.remainder(mean[2] - expected[1][2], 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(covariance, expected[2], atol=1e-9)


def test_where_no_particle_is_near_there_is_no_weight_and_the_pose_stays():
    total, mean, _ = cluster.moments_around(np.zeros((1, 3)), np.ones(1), Pose2D(9.0, 9.0, 1.0), 0.75, 0.8)
    assert (total, mean) == (0.0, (9.0, 9.0, 1.0))


@settings(deadline=None)
@given(seeds)
def test_the_heaviest_bin_is_that_of_its_twin(seed):
    rng = np.random.default_rng(seed)
    particles, weights = rng.normal(0.0, 0.6, (60, 3)), rng.uniform(0.1, 1.0, 60)
    sums: dict[tuple[int, int, int], float] = {}
    for particle, weight in zip(particles, weights, strict=True):
        sums[twin.bin_of(particle)] = sums.get(twin.bin_of(particle), 0.0) + weight
    assert twin.bin_of(particles[cluster.heaviest_bin(particles, weights)]) == max(sums, key=sums.__getitem__)


@settings(deadline=None)
@given(seeds, st.floats(0.1, 3.0), st.integers(1, 50))
def test_so_many_particles_do_as_by_the_twin(seed, spread, least):
    rng = np.random.default_rng(seed)
    particles, weights, picks = rng.normal(0.0, spread, (300, 3)), rng.uniform(0.0, 1.0, 300), rng.random(400)
    expected = twin.enough(particles, weights, picks, least, 0.05, 0.99)
    assert resample.enough(particles, weights, picks, least, 0.05, 0.99) == expected


@given(seeds)
def test_free_cells_are_found_by_their_numbers(seed):
    rng = np.random.default_rng(seed)
    data = rng.choice(np.array([FREE, OCCUPIED, -1], np.int8), (rng.integers(1, 9), rng.integers(1, 9)))
    free = np.argwhere(data == FREE)
    below = free_cells.count_free(data)
    assert below[-1] == len(free)
    numbers = np.sort(rng.integers(0, len(free), 20)) if len(free) else np.empty(0, np.int64)
    np.testing.assert_array_equal(free_cells.find_free(data, below, numbers), free[numbers])


@given(st.lists(st.floats(0, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_particles_are_drawn_as_by_their_twin(weights, count, start):
    weights = np.array(weights) + 1e-6
    weights /= weights.sum()
    drawn = resample.draw_low_variance(weights, count, start)
    assert (drawn == twin.draw_low_variance(weights, count, start)).all()


@given(st.lists(st.floats(0.001, 1), min_size=1, max_size=50), st.integers(1, 200), st.floats(0, 1, exclude_max=True))
def test_each_particle_is_drawn_as_often_as_it_weighs_give_or_take_one(weights, count, start):
    weights = np.array(weights) / np.sum(weights)
    drawn = np.bincount(resample.draw_low_variance(weights, count, start), minlength=len(weights))
    assert (np.abs(drawn - count * weights) <= 1.0 + 1e-9).all()


@pytest.mark.parametrize(
    ("module", "kernel"),
    [
        (likelihood_field, likelihood_field.score_serial),
        (motion, motion.move_diff_serial),
        (resample, resample.draw_low_variance),
        (resample, resample.enough),
        (cluster, cluster.heaviest_bin),
        (cluster, cluster.moments_around),
    ],
)
def test_a_warm_kernel_compiles_nothing_more_for_what_production_calls_it_with(module, kernel):
    module.warm()
    warm = list(kernel.signatures)
    parameters = AmclParameters(min_particles=10, max_particles=10, resample_interval=1)
    info = GridInfo(0.05, 20, 20)
    grid = GridMap(np.eye(20, dtype=np.int8) * 100, info)
    localization = ParticleFilter(build_layers(grid), parameters)
    for x in (0.0, 0.5):
        localization.update(Pose2D(x, 0, 0), np.array([[0.1, 0.2]]), 8.0)
    assert kernel.signatures == warm
