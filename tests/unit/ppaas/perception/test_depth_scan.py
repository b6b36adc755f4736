"""Depth images as scans, beside a slow twin."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ppaas.errors import InvalidInput, InvalidParameter
from ppaas.perception.depth_scan import DepthScanner, DepthScanParameters, PinholeCamera
from ppaas.perception.kernels import depth as kernels

CAMERA = PinholeCamera(16, 9, 12.0, 7.3, 4.1)


def twin(image: np.ndarray, camera: PinholeCamera, own: DepthScanParameters) -> list[float]:
    """Slow twin: return the ranges as ROS's node computes them, pixel by pixel."""
    angles = [-math.atan2(u - camera.cx, camera.fx) for u in range(camera.width)]
    increment = (angles[0] - angles[-1]) / (camera.width - 1)
    ranges = [math.nan] * camera.width
    first = int(camera.cy - own.scan_height / 2)
    for v in range(first, first + own.scan_height):
        for u in range(camera.width):
            depth = float(image[v, u]) * (0.001 if image.dtype == np.uint16 else 1.0)
            seen = math.hypot((u - camera.cx) * depth / camera.fx, depth)
            beam = int((angles[u] - angles[-1]) / increment + 1e-9)
            if depth > 0.0 and own.range_min <= seen <= own.range_max and not ranges[beam] <= seen:
                ranges[beam] = seen
    return ranges


depths_m = st.floats(0.0, 12.0, width=32) | st.sampled_from([math.nan, math.inf])


@given(arrays.arrays(np.float32, (9, 16), elements=depths_m), st.integers(1, 8))
def test_scan_of_metres_agrees_with_the_twin(image, rows):
    own = DepthScanParameters(scan_height=rows)
    # A depth exactly at a limit may be rounded to either side of it.
    slant = np.hypot(1.0, (np.arange(16) - CAMERA.cx) / CAMERA.fx)
    for limit in (own.range_min, own.range_max):
        image[np.isclose(image * slant, limit, atol=1e-4)] = 0.0
    np.testing.assert_allclose(DepthScanner(CAMERA, own).scan(image), twin(image, CAMERA, own), rtol=1e-5)


@given(arrays.arrays(np.uint16, (9, 16), elements=st.integers(0, 65535)), st.integers(1, 8))
def test_scan_of_millimetres_agrees_with_the_twin(image, rows):
    own = DepthScanParameters(scan_height=rows, range_min=0.3, range_max=70.0)
    image[image == 65535] = 0
    slant = np.hypot(1.0, (np.arange(16) - CAMERA.cx) / CAMERA.fx)
    image[np.isclose(image * slant * 1e-3, own.range_min, atol=1e-5)] = 0
    np.testing.assert_allclose(DepthScanner(CAMERA, own).scan(image), twin(image, CAMERA, own), rtol=1e-5)


def test_wall_ahead_is_a_straight_line():
    scanner = DepthScanner(PinholeCamera(640, 480, 525.0, 319.5, 239.5), DepthScanParameters(scan_height=10))
    ranges = scanner.scan(np.full((480, 640), 2000, np.uint16))
    angles = scanner.angle_min + scanner.angle_increment * np.arange(640)
    assert scanner.angle_min == pytest.approx(-scanner.angle_max) == pytest.approx(-math.atan(319.5 / 525.0))
    seen = ~np.isnan(ranges)
    assert seen.sum() > 500
    # A beam is one or two columns wide.
    np.testing.assert_allclose((ranges * np.cos(angles))[seen], 2.0, atol=0.01)


def test_nearest_depth_within_the_scan_rows_is_taken():
    image = np.full((9, 16), 5000, np.uint16)
    image[0], image[3, 7], image[4, 7] = 500, 2000, 3000
    own = DepthScanParameters(scan_height=2)
    ranges = DepthScanner(PinholeCamera(16, 9, 100.0, 7.0, 5.0), own).scan(image)
    assert np.nanmin(ranges) == pytest.approx(3.0)
    ranges = DepthScanner(PinholeCamera(16, 9, 100.0, 7.0, 4.0), own).scan(image)
    assert np.nanmin(ranges) == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("image", "why"),
    [
        (np.zeros((8, 16), np.uint16), "16×9 pixels"),
        (np.zeros((9, 16), np.float64), "float64"),
        (np.zeros((9, 16), np.uint8), "uint8"),
    ],
)
def test_an_image_of_another_kind_is_refused(image, why):
    with pytest.raises(InvalidInput, match=why):
        DepthScanner(CAMERA, DepthScanParameters()).scan(image)


@pytest.mark.parametrize(
    "wrong", [(1, 9, 12.0, 0.0, 4.0), (16, 0, 12.0, 7.0, 0.0), (16, 9, 0.0, 7.0, 4.0), (16, 9, math.nan, 7.0, 4.0),
              (16, 9, 12.0, 16.0, 4.0), (16, 9, 12.0, 7.0, math.nan), (1 << 20, 1 << 20, 12.0, 7.0, 4.0)],
)  # fmt: skip
def test_an_invalid_camera_is_refused(wrong):
    with pytest.raises(InvalidInput):
        PinholeCamera(*wrong)


@pytest.mark.parametrize(
    "wrong",
    [
        {"scan_height": 0}, {"range_min": -0.1}, {"range_min": 10.0}, {"range_max": math.inf}, {"range_max": math.nan},
        {"scan_time": -1.0}, {"output_frame_id": ""},
    ],
)  # fmt: skip
def test_parameters_out_of_range_are_refused_by_name(wrong):
    with pytest.raises(InvalidParameter, match=next(iter(wrong))):
        DepthScanParameters(**wrong)


def test_more_rows_than_the_camera_has_are_refused():
    with pytest.raises(InvalidParameter, match="scan_height 10"):
        DepthScanner(CAMERA, DepthScanParameters(scan_height=10))


def test_warm_calls_every_kernel():
    kernels.warm()
    assert len(kernels.nearest.nopython_signatures) == 2
    assert kernels.spread.nopython_signatures
