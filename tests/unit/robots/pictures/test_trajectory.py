"""Pictures of maps with trajectories."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from robots.pictures import map_pictures
from robots.pictures.path import GOAL, PATH, START

CELLS = np.full((40, 60), FREE, np.int8)
CELLS[0], CELLS[:, -1] = OCCUPIED, UNKNOWN
GRID = GridMap(CELLS, GridInfo(0.5, 60, 40, Pose2D(-10.0, -5.0)))
POSES = np.array([(-5.0, 0.0, 0.0), (5.0, 0.0, 0.0), (5.0, 10.0, 1.0)])


def test_the_map_is_drawn_with_north_up_and_the_path_on_it() -> None:
    picture = map_pictures.draw_trajectory(GRID, POSES).picture
    assert picture.size == (60, 40)
    assert picture.getpixel((5, 39)) == (40, 46, 56)
    assert picture.getpixel((59, 5)) == (214, 219, 226)
    assert picture.getpixel((10, 30)) == START
    assert picture.getpixel((30, 10)) == GOAL
    assert picture.getpixel((20, 30)) == PATH
    assert picture.getpixel((50, 20)) == (255, 255, 255)


def test_walls_stay_visible_in_a_reduced_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_pictures, "MOST_TRAJECTORY_PIXELS", 20)
    picture = map_pictures.draw_trajectory(GRID, POSES).picture
    assert picture.size == (20, 14)
    assert picture.getpixel((15, 13)) == (40, 46, 56)


def test_the_picture_is_a_png_file(tmp_path: Path) -> None:
    map_pictures.write_trajectory(tmp_path / "map.png", GRID, POSES)
    assert Image.open(tmp_path / "map.png").format == "PNG"
    for name in ("map.jpg", "missing/map.png"):
        with pytest.raises(InvalidInput):
            map_pictures.write_trajectory(tmp_path / name, GRID, POSES)
