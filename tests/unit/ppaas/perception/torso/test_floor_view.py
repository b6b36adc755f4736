import math

import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.perception.depth_scan import PinholeCamera
from ppaas.perception.torso.floor_view import FloorView
from robots.sim.depth.camera import DepthCameraModel
from robots.sim.depth.shapes import box, shapes_of
from tests.support.world.depth_images import SMALL, image_of, view_of

BOARD = shapes_of([], [box((3.05, 0.0, 1.0), (0.05, 2.0, 1.0))])


def test_points_are_placed_over_the_floor() -> None:
    view = view_of()
    points = view.points(image_of(BOARD))
    middle = points.x[110:130, 150:170]
    assert np.nanmean(middle) == pytest.approx(3.0, abs=0.01)
    assert abs(np.nanmean(points.y[120, 150:170])) < 0.02
    below = points.z[-5:]
    assert np.nanmax(np.abs(below)) < 0.05


def test_wide_images_are_thinned_out() -> None:
    model = DepthCameraModel(640, 480)
    assert view_of(model).shape == (240, 320)
    assert view_of(model).points(image_of(BOARD, model=model)).x.shape == (240, 320)


@pytest.mark.parametrize("tilt", [math.radians(-2.0), math.radians(2.0)])
def test_the_floor_is_fitted_if_the_mount_is_not_exact(tilt: float) -> None:
    view, image = view_of(tilt=tilt), image_of()
    for _ in range(20):
        points = view.points(image)
    assert view.floor[0] == pytest.approx(-math.tan(tilt), abs=0.006)
    floor = points.z[200:]
    assert abs(np.nanmean(floor)) < 0.02


def test_walls_that_end_at_the_floor_are_not_fitted() -> None:
    view = view_of()
    for _ in range(10):
        view.points(image_of(BOARD))
    assert np.abs(view.floor).max() < 0.01


def test_pixels_show_the_points_that_they_were_made_of() -> None:
    view = view_of()
    points = view.points(image_of(BOARD))
    known = ~np.isnan(points.x)
    index, inside = view.pixels(points.x[known], points.y[known], points.z[known])
    assert inside.all()
    assert np.array_equal(index, np.flatnonzero(known))
    _, behind = view.pixels(np.float32([-1.0]), np.float32([0.0]), np.float32([1.0]))
    assert not behind.any()


def test_depths_in_metres_and_in_millimetres_give_the_same_points() -> None:
    image = image_of(BOARD)
    metres = np.where(image == 0, np.nan, image / 1000.0).astype(np.float32)
    for one, other in zip(view_of().points(image), view_of().points(metres), strict=True):
        np.testing.assert_allclose(one, other, atol=1e-5)


def test_invalid_input_is_refused() -> None:
    with pytest.raises(InvalidInput, match="320×240"):
        view_of().points(np.zeros((2, 2), np.uint16))
    with pytest.raises(InvalidInput, match="finite matrix"):
        FloorView(PinholeCamera(SMALL.width, SMALL.height, 300.0, 160.0, 120.0), 300.0, np.full((4, 4), np.nan))
    with pytest.raises(InvalidInput, match="focal length"):
        FloorView(PinholeCamera(SMALL.width, SMALL.height, 300.0, 160.0, 120.0), 0.0, np.eye(4))
