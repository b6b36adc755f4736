"""Pictures of lanes: their cells on the map, and arrows where robots drive one way."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput
from ppaas.maps.grid import FREE, GridMap
from robots.pictures import map_pictures
from robots.pictures.path import PATH
from tests.support.fleet.lanes import INFO, hall, line

GRID = GridMap(np.full(INFO.shape, FREE, np.int8), INFO)
CELLS = hall(line((2, 2), (18, 2)), line((2, 2), (2, 10)), line((2, 10), (18, 10), one_way=True))


def test_lanes_are_drawn_where_they_are_in_their_colours() -> None:
    image = map_pictures.draw_lanes(GRID, CELLS)
    assert max(image.picture.size) == 1000
    both, one_way = image.pixels(np.array([[2.0, 5.0], [10.0, 10.0]]))
    assert image.picture.getpixel((round(both[0]), round(both[1]))) == PATH
    colours = {colour for _, colour in image.picture.getcolors(1 << 20)}
    assert {PATH, map_pictures._ONE_WAY, map_pictures._CELL, (255, 255, 255)} <= colours
    near = image.picture.crop((int(one_way[0]) - 40, int(one_way[1]) - 20, int(one_way[0]) + 40, int(one_way[1]) + 20))
    assert map_pictures._ONE_WAY in {colour for _, colour in near.getcolors(1 << 20)}


def test_the_picture_is_a_png_file(tmp_path: Path) -> None:
    map_pictures.write_lanes(tmp_path / "lanes.png", GRID, CELLS)
    with Image.open(tmp_path / "lanes.png") as picture:
        assert picture.size == (1000, 600)
    with pytest.raises(InvalidInput, match="PNG"):
        map_pictures.write_lanes(tmp_path / "lanes.jpg", GRID, CELLS)
    with pytest.raises(InvalidInput, match="cannot write"):
        map_pictures.write_lanes(tmp_path / "none" / "lanes.png", GRID, CELLS)
