"""Points of depth images."""

import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.mapping.volume.depth_points import points_of_depth
from ppaas.perception.depth_scan import PinholeCamera

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
