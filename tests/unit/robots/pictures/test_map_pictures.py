"""Pictures on a map: lanes, a trajectory, zones."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ppaas.errors import InvalidInput, ZoneFault
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap
from robots.pictures import map_pictures
from robots.pictures.map_pictures import draw_zones
from robots.pictures.path import GOAL, PATH, START
from tests.support.fleet.lanes import INFO, hall, line
from tests.support.geojson import LINE, collection, feature

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


DRIVEN_CELLS = np.full((40, 60), FREE, np.int8)
DRIVEN_CELLS[0], DRIVEN_CELLS[:, -1] = OCCUPIED, UNKNOWN
DRIVEN_GRID = GridMap(DRIVEN_CELLS, GridInfo(0.5, 60, 40, Pose2D(-10.0, -5.0)))
POSES = np.array([(-5.0, 0.0, 0.0), (5.0, 0.0, 0.0), (5.0, 10.0, 1.0)])


def test_the_map_is_drawn_with_north_up_and_the_path_on_it() -> None:
    picture = map_pictures.draw_trajectory(DRIVEN_GRID, POSES).picture
    assert picture.size == (60, 40)
    assert picture.getpixel((5, 39)) == (40, 46, 56)
    assert picture.getpixel((59, 5)) == (214, 219, 226)
    assert picture.getpixel((10, 30)) == START
    assert picture.getpixel((30, 10)) == GOAL
    assert picture.getpixel((20, 30)) == PATH
    assert picture.getpixel((50, 20)) == (255, 255, 255)


def test_walls_stay_visible_in_a_reduced_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(map_pictures, "MOST_TRAJECTORY_PIXELS", 20)
    picture = map_pictures.draw_trajectory(DRIVEN_GRID, POSES).picture
    assert picture.size == (20, 14)
    assert picture.getpixel((15, 13)) == (40, 46, 56)


def test_the_picture_of_a_trajectory_is_a_png_file(tmp_path: Path) -> None:
    map_pictures.write_trajectory(tmp_path / "map.png", DRIVEN_GRID, POSES)
    assert Image.open(tmp_path / "map.png").format == "PNG"
    for name in ("map.jpg", "missing/map.png"):
        with pytest.raises(InvalidInput):
            map_pictures.write_trajectory(tmp_path / name, DRIVEN_GRID, POSES)


ZONED_GRID = GridMap(np.zeros((20, 20), np.int8), GridInfo(0.1, 20, 20, Pose2D(0.0, 0.0, 0.0)))
BOW_TIE = {"type": "Polygon", "coordinates": [[[0.2, 0.2], [1.8, 1.8], [1.8, 0.2], [0.2, 1.8], [0.2, 0.2]]]}
WHITE = (255, 255, 255)


def test_the_quarters_of_a_crossed_outline_show_and_its_crossing_is_marked() -> None:
    fault = ZoneFault("a", "its outline crosses itself", (1.0, 1.0))
    image = draw_zones(ZONED_GRID, collection(feature(BOW_TIE)), [fault])
    at = {place: image.picture.getpixel(image.pixels(np.array([place]))[0]) for place in ((0.4, 1.0), (1.0, 0.4))}
    assert at[0.4, 1.0] != WHITE
    assert at[1.0, 0.4] == WHITE
    assert image.picture.getpixel(image.pixels(np.array([(1.0, 1.0)]))[0]) == (255, 0, 0)


def test_features_that_are_no_zones_are_left_out() -> None:
    point = feature({"type": "Point", "coordinates": [0, 0]})
    odd = [feature(None), point, {"type": "Feature", "geometry": LINE, "properties": None}, 1]
    odd.append({"type": "Feature", "geometry": LINE, "properties": ["a"]})
    odd.append(feature({"type": "LineString", "coordinates": [[float("nan"), 0], [1, 1]]}))
    image = draw_zones(ZONED_GRID, b"\xef\xbb\xbf" + collection(*odd), [ZoneFault("a", "it has no geometry")])
    assert image.picture.size == (1000, 1000)
