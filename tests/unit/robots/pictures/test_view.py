import numpy as np
import pytest

from ppaas.geometry import Pose2D
from robots.pictures import path
from robots.pictures.path import OBSTACLE, OVERSAMPLING, UNKNOWN, View, palette
from tests.support.world import grids


def test_a_point_is_drawn_at_its_cell_for_any_map_origin():
    costs = np.zeros((30, 50), np.uint8)
    costs[4, 7] = 254
    for origin in (Pose2D(0.0, 0.0), Pose2D(-3.0, 8.0, 2.1)):
        map_ = grids.of(costs, 0.05, origin)
        view = View.of(map_, map_.info.to_world([[4, 7]]))
        [(x, y)] = view.pixels(map_.info.to_world([[4, 7]]))
        picture = view.picture()
        assert picture.getpixel((int(x), int(y))) == OBSTACLE
        assert picture.getpixel((int(x + view.scale), int(y))) != OBSTACLE
        assert picture.size == view.size


def test_unknown_cells_are_cropped_except_along_the_path():
    costs = np.full((300, 400), 255, np.uint8)
    costs[100:110, 200:220] = 0
    map_ = grids.of(costs)
    known = View.of(map_, map_.info.to_world([[105, 210]]))
    assert (known.bottom, known.top, known.left, known.right) == (92, 118, 192, 228)
    led_out = View.of(map_, map_.info.to_world([[105, 210], [290, 390]]))
    assert (led_out.bottom, led_out.top, led_out.left, led_out.right) == (92, 299, 192, 399)


@pytest.mark.parametrize("shape", [(1, 1), (1, 3000), (3000, 1), (20, 30), (2500, 3000)])
def test_any_map_fits_the_picture(shape):
    map_ = grids.of(np.zeros(shape, np.uint8))
    view = View.of(map_, map_.info.to_world([[0, 0]]))
    width, height = view.size
    assert 1 <= width <= path.WIDEST * OVERSAMPLING
    assert 1 <= height <= path.HIGHEST * OVERSAMPLING
    if max(shape) < 1000:
        assert view.scale % OVERSAMPLING == 0


def test_higher_costs_have_darker_colours():
    colours = palette().astype(int)
    assert tuple(colours[255]) == UNKNOWN
    assert (np.diff(colours[0:255].sum(axis=1)) <= 0).all()
