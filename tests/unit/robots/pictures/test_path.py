"""Pictures of paths."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, poses_along
from robots.pictures import path
from robots.pictures.path import (
    GOAL,
    HIGHEST,
    OBSTACLE,
    OVERSAMPLING,
    PATH,
    START,
    UNKNOWN,
    WIDEST,
    View,
    _round_length,
    draw,
    palette,
    write_picture,
)
from robots.plans.offline import PlannedRobot, costmap_for, plan
from tests.support.sources import ROOT
from tests.support.world import grids

OPTIONS = {"radius": 0.18, "title": "office", "facts": ["12.5 m", "0.4 ms"]}


def count(picture: Image.Image, colour: tuple[int, int, int]) -> int:
    """Return the number of pixels of a colour."""
    return int((np.asarray(picture) == colour).all(axis=-1).sum())


def test_a_picture_shows_path_start_and_goal(tmp_path):
    costmap = costmap_for(ROOT / "docs" / "examples" / "office.yaml", PlannedRobot())
    result = plan(costmap, Pose2D(2, 2), Pose2D(10, 8, 1.57), "astar", 0.0)
    write_picture(tmp_path / "office.PNG", costmap, result.poses, **OPTIONS)
    with Image.open(tmp_path / "office.PNG") as picture:
        assert picture.format == "PNG"
        assert WIDEST / 2 < picture.width < WIDEST + 200
        assert picture.height < HIGHEST + 200
        pixels = picture.convert("RGB")
    assert count(pixels, PATH) > 1_000
    assert count(pixels, START) > 100
    assert count(pixels, GOAL) > 100


@pytest.mark.parametrize("shape", [(1, 1), (1, 2000), (1500, 2)])
def test_maps_of_any_shape_are_drawn(shape):
    costmap = grids.of(np.zeros(shape, np.uint8), 0.05)
    ends = costmap.info.to_world([(0, 0), (shape[0] - 1, shape[1] - 1)])
    picture = draw(costmap, poses_along(ends, 0.0), **OPTIONS)
    assert count(picture, GOAL) > 100


def test_an_unknown_map_is_drawn_around_the_path():
    costmap = grids.of(np.full((40, 40), 255, np.uint8))
    assert draw(costmap, poses_along(np.array([[20.0, 20.0]])), **OPTIONS).width > 100


@pytest.mark.parametrize(("name", "error"), [("a.jpg", "use a.png"), ("a", "use a.png"), ("no/a.png", "cannot write")])
def test_an_unwritable_picture_is_refused_with_the_reason(tmp_path, name, error):
    costmap = grids.of(np.zeros((2, 2), np.uint8))
    with pytest.raises(InvalidInput, match=error):
        write_picture(tmp_path / Path(name), costmap, poses_along(np.zeros((1, 2))), **OPTIONS)


@pytest.mark.parametrize(
    ("most", "length"), [(1.0, 1.0), (1.99, 1.0), (2.1, 2.0), (49.0, 20.0), (50.0, 50.0), (0.07, 0.05)]
)
def test_the_scale_bar_has_a_round_length(most, length):
    assert _round_length(most) == pytest.approx(length)


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
