import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.localization.kernels import sight
from ppaas.maps.grid import GridInfo
from tests.reference.driving import localization as twin
from tests.support.budget import examples
from tests.support.world.scattered_walls import distances

seeds = st.integers(0, 2**32 - 1)
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
