"""Registration of clouds by ``small_gicp``, and its absence."""

import sys

import numpy as np
import pytest

from ppaas.errors import Unavailable
from ppaas.mapping.volume.registration import MOST_SHIFT, CloudRegistration, apply, library

SIZE = np.array([4.0, 3.0, 2.5])


def corner(seed):
    """Return points of three walls, (n, 3)."""
    random = np.random.default_rng(seed)
    points = random.uniform(0.0, 1.0, (9000, 3)) * SIZE
    for axis in range(3):
        points[axis * 3000 : (axis + 1) * 3000, axis] = 0.0
    return (points + random.normal(0.0, 0.003, points.shape)).astype(np.float32)


def shifted(points, shift, turn=0.0):
    c, s = np.cos(turn), np.sin(turn)
    return (points @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) + shift).astype(np.float32)


def error(correction, points, true):
    return float(np.linalg.norm(apply(correction, points) - true, axis=1).mean())


@pytest.fixture
def registration():
    pytest.importorskip("small_gicp")
    return CloudRegistration()


def test_a_cloud_is_put_where_it_fits_but_for_the_part_that_draws_it_back(registration):
    assert np.array_equal(registration.correction(corner(1)), np.eye(4))
    wrong = shifted(corner(2), (0.03, -0.04, 0.02), 0.01)
    assert error(registration.correction(wrong), wrong, corner(2)) < 0.35 * error(np.eye(4), wrong, corner(2))


@pytest.mark.parametrize("far", [(2000.0, -3000.0, 10.0), (20_000.0, 30_000.0, 0.0)])
def test_a_cloud_far_from_the_origin_is_corrected_like_one_near_it(far):
    pytest.importorskip("small_gicp")
    wrong, corrected = shifted(corner(2), (0.03, -0.04, 0.02), 0.01), []
    for place in ((0.0, 0.0, 0.0), far):
        registration = CloudRegistration()
        registration.correction(corner(1) + np.float32(place))
        corrected.append(
            apply(registration.correction(wrong + np.float32(place)), wrong + np.float32(place)) - np.float32(place)
        )
    near, away = corrected
    # float32 keeps 2 mm at 30 km.
    assert np.abs(away - near).max() < 0.006


def test_a_cloud_of_another_place_is_not_corrected(registration):
    registration.correction(corner(1))
    for shift in ((2.0 * MOST_SHIFT, 0.0, 0.0), (20.0, 0.0, 0.0)):
        assert registration.correction(shifted(corner(2), shift)) == pytest.approx(np.eye(4), abs=1e-3)


def test_small_clouds_and_the_first_after_forgetting_are_not_corrected(registration):
    registration.correction(corner(1))
    assert np.array_equal(registration.correction(shifted(corner(2), (0.05, 0.0, 0.0))[:50]), np.eye(4))
    registration.forget()
    assert np.array_equal(registration.correction(shifted(corner(2), (0.05, 0.0, 0.0))), np.eye(4))


def test_without_the_library_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "small_gicp", None)
    with pytest.raises(Unavailable, match=r"pip install '\.\[mapping\]'"):
        library()
