"""Pictures of paths."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D, poses_along
from robots.pictures.path import GOAL, HIGHEST, PATH, START, WIDEST, _round_length, draw, write_picture
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
