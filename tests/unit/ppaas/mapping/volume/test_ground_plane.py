"""Points of depth images; and ground filter: floors, tables, and clouds without a floor."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.mapping.volume.depth_points import points_of_depth
from ppaas.mapping.volume.ground_plane import GroundFilterParameters, ground_mask
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
