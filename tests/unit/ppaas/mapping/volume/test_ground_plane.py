"""Clouds: points of depth images, floors that are filtered out, and registration by ``small_gicp``, or its absence."""

import math
import sys

import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidParameter, Unavailable
from ppaas.mapping.volume.depth_points import points_of_depth
from ppaas.mapping.volume.ground_plane import GroundFilterParameters, ground_mask
from ppaas.mapping.volume.registration import MOST_SHIFT, CloudRegistration, apply, library
from ppaas.perception.depth_scan import PinholeCamera

DEFAULTS = GroundFilterParameters()


def level(height, count, seed=1, tilt=0.0):
    random = np.random.default_rng(seed)
    points = random.uniform(-2.0, 2.0, (count, 3))
    points[:, 2] = height + tilt * points[:, 0] + random.normal(0.0, 0.01, count)
    return points.astype(np.float32)


def wall(count):
    points = level(0.0, count, 3)
    return points[:, [2, 1, 0]] + np.array([2.0, 0.0, 2.0], np.float32)


def test_points_of_the_floor_are_found_and_no_others():
    mask = ground_mask(np.concatenate((level(0.0, 400), wall(400))), DEFAULTS)
    assert mask[:400].mean() > 0.99
    assert mask[400:].mean() < 0.05


def test_a_table_is_no_floor_even_if_it_is_larger():
    mask = ground_mask(np.concatenate((level(0.7, 800), level(0.02, 200, 2))), DEFAULTS)
    assert not mask[:800].any()
    assert mask[800:].mean() > 0.99


def test_a_floor_may_be_tilted_within_the_angle():
    for tilt, found in ((0.1, True), (0.6, False)):
        mask = ground_mask(level(0.0, 400, tilt=tilt), DEFAULTS)
        assert bool(mask.mean() > 0.95) is found


def test_without_a_plane_the_points_near_the_height_of_the_floor_are_taken():
    points = wall(400)
    mask = ground_mask(points, DEFAULTS)
    assert np.array_equal(mask, np.abs(points[:, 2]) <= DEFAULTS.plane_distance)


def test_small_clouds_and_points_that_are_not_finite_have_no_floor():
    assert not ground_mask(level(0.0, 20), DEFAULTS).any()
    points = level(0.0, 100)
    points[:30, 1] = np.nan
    assert not ground_mask(points, DEFAULTS)[:30].any()


@pytest.mark.parametrize("wrong", [{"distance": 0.0}, {"angle": 2.0}, {"plane_distance": -1.0}])
def test_invalid_parameters_are_refused(wrong):
    with pytest.raises(InvalidParameter):
        GroundFilterParameters(**wrong)


CAMERA = PinholeCamera(5, 4, 10.0, 2.0, 1.5)
POSE = np.array([[0.0, 0.0, 1.0, 1.0], [-1.0, 0.0, 0.0, 2.0], [0.0, -1.0, 0.0, 3.0], [0.0, 0.0, 0.0, 1.0]])
"""Camera that looks along x of the map frame, at (1, 2, 3)."""


def image_of(kind):
    image = np.arange(1, 21).reshape(4, 5) * (100 if kind == np.uint16 else 0.1)
    return image.astype(kind)


@pytest.mark.parametrize("kind", [np.uint16, np.float32])
@pytest.mark.parametrize("fy", [None, 20.0])
def test_points_are_those_of_the_pinhole_model(kind, fy):
    expected = []
    for v in range(4):
        for u in range(5):
            z = (v * 5 + u + 1) * 0.1
            expected.append([1.0 + z, 2.0 - (u - 2.0) / 10.0 * z, 3.0 - (v - 1.5) / (fy or 10.0) * z])
    points = points_of_depth(image_of(kind), CAMERA, POSE, fy=fy)
    assert points.dtype == np.float32
    assert np.allclose(points, expected, atol=1e-6)


@pytest.mark.parametrize(("kind", "nothing"), [(np.uint16, (0, 65535)), (np.float32, (0.0, np.nan, np.inf, -1.0))])
def test_pixels_without_a_reading_have_no_point(kind, nothing):
    image = image_of(kind)
    image[1, : len(nothing)] = nothing
    assert len(points_of_depth(image, CAMERA, POSE)) == 20 - len(nothing)


def test_depths_beyond_the_range_are_ignored():
    assert len(points_of_depth(image_of(np.uint16), CAMERA, POSE, range_max=1.05)) == 10


@pytest.mark.parametrize(
    ("image", "pose", "fy"),
    [
        (np.zeros((4, 4), np.uint16), POSE, None), (np.zeros((4, 5)), POSE, None),
        (np.zeros((4, 5), np.uint16), POSE[:3], None), (np.zeros((4, 5), np.uint16), POSE * math.nan, None),
        (np.zeros((4, 5), np.uint16), POSE, 0.0),
    ],
)  # fmt: skip
def test_invalid_images_and_poses_are_refused(image, pose, fy):
    with pytest.raises(InvalidInput):
        points_of_depth(image, CAMERA, pose, fy=fy)


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
