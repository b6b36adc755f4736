import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.geometry import Pose2D
from ppaas.mapping.closures.branch_and_bound import Blur, Excluded, MotionWindow, build_pyramid, search
from ppaas.mapping.closures.closing import Rivalry, rival_match
from ppaas.mapping.closures.kernels import points as kernels
from tests.reference.mapping import closures as twin

WINDOW = MotionWindow(1.0, 0.6, 0.3, 0.02)
BLUR = Blur(0.05, 0.08)


def room():
    """Return points on the walls of a room of 6 by 4 m with a niche."""
    along, across = np.arange(-3.0, 3.0, 0.05), np.arange(-2.0, 2.0, 0.05)
    sides = [np.stack((along, np.full_like(along, y)), axis=1) for y in (-2.0, 2.0)]
    sides += [np.stack((np.full_like(across, x), across), axis=1) for x in (-3.0, 3.0)]
    return np.concatenate([*sides, np.stack((along[:30] * 0.2, np.full(30, 1.2)), axis=1)])


def corridor(period):
    """Return points of a corridor along x with equal posts."""
    along = np.arange(-20.0, 20.0, 0.05)
    walls = [np.stack((along, np.full_like(along, y)), axis=1) for y in (-1.0, 1.0)]
    posts = [(x, y) for x in np.arange(-20.0, 20.0, period) for y in np.arange(0.6, 1.0, 0.05)]
    return np.concatenate([*walls, posts])


def moved(points, motion):
    """Return points as they are before a motion that brings them to where they are given."""
    back = Pose2D(*motion).inverse()
    c, s = math.cos(back.theta), math.sin(back.theta)
    return points @ np.array([[c, s], [-s, c]]) + (back.x, back.y)


def pyramid_of(points, window):
    return build_pyramid(points, (30.0, 30.0), BLUR, window.levels(BLUR.resolution))


@pytest.mark.parametrize("motion", [(0.0, 0.0, 0.0), (0.8, -0.5, 0.2), (-0.95, 0.55, -0.28)])
def test_search_finds_the_motion_that_brings_points_back(motion):
    found = search(pyramid_of(room(), WINDOW), moved(room(), motion), WINDOW)
    assert found.score > 0.8
    np.testing.assert_allclose(found.motion, motion, atol=0.06)


def test_search_finds_nothing_beyond_the_least_score_or_without_points():
    pyramid = pyramid_of(room(), WINDOW)
    assert search(pyramid, moved(room(), (3.0, 0.0, 0.0)), WINDOW, least=0.9) is None
    assert search(pyramid, np.empty((0, 2)), WINDOW) is None


def test_pyramid_without_points_scores_nothing():
    assert search(pyramid_of(np.empty((0, 2)), WINDOW), room(), WINDOW) is None


def test_excluded_motion_is_not_found_again():
    pyramid, points = pyramid_of(room(), WINDOW), moved(room(), (0.4, 0.2, 0.0))
    best = search(pyramid, points, WINDOW)
    other = search(pyramid, points, WINDOW, excluded=Excluded(best.motion, 0.5, 1.0))
    assert math.hypot(other.motion.x - best.motion.x, other.motion.y - best.motion.y) >= 0.49
    assert other.score < best.score


def test_equal_posts_of_a_corridor_are_rivals_and_a_room_has_none():
    window = MotionWindow(5.0, 0.3, 0.05)
    seen = corridor(2.0)[np.abs(corridor(2.0)[:, 0]) < 6.0]
    pyramid = pyramid_of(corridor(2.0), window)
    best = search(pyramid, seen, window)
    assert rival_match(pyramid, seen, window, best, Rivalry()) is not None
    pyramid = pyramid_of(room(), window)
    best = search(pyramid, room(), window)
    assert rival_match(pyramid, room(), window, best, Rivalry()) is None


seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_gathered_points_equal_the_twin(seed):
    rng = np.random.default_rng(seed)
    points, valid = rng.normal(size=(3, 5, 2)).astype(np.float32), rng.random((3, 5)) < 0.7
    poses, frame = rng.normal(size=(3, 3)), rng.normal(size=3)
    found = kernels.gather(points, valid, poses, frame)
    np.testing.assert_allclose(found, twin.gather(points, valid, poses, frame), atol=1e-12)


@given(seeds)
def test_thinned_points_equal_the_twin(seed):
    points = np.random.default_rng(seed).uniform(-1.2, 1.2, (40, 2))
    np.testing.assert_allclose(kernels.thin(points, 0.3, 1.0), twin.thin(points, 0.3, 1.0), atol=1e-12)


def test_no_points_stay_no_points():
    assert kernels.thin(np.empty((0, 2)), 0.1, 5.0).shape == (0, 2)
