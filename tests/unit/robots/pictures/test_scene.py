"""Pictures of a map with zones, robots and coordinates."""

import json

import numpy as np
from numpy.typing import NDArray

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from robots.pictures.path import FAINT, GOAL
from robots.pictures.scene import draw_scene

SIZE = 400
INFO = GridInfo(0.1, 40, 20, Pose2D(-1.0, 2.0))


def picture(zones: bytes | None = None, **robots: Pose2D) -> NDArray[np.uint8]:
    grid = GridMap(np.zeros((20, 40), np.int8), INFO)
    return np.asarray(draw_scene(grid, zones, robots, SIZE).picture)


def test_a_robot_is_drawn_where_it_is_and_heads_where_it_looks() -> None:
    plain, drawn = picture(), picture(tb1=Pose2D(1.5, 3.2, 0.0))
    assert plain.shape == (200, 400, 3)
    row, column = 200 - round((3.2 - 2.0) * 100), round((1.5 + 1.0) * 100)
    assert tuple(drawn[row, column]) == GOAL
    changed = np.argwhere((drawn == GOAL).all(axis=-1) & ~(plain == GOAL).all(axis=-1))
    right, left = changed[:, 1].max() - column, column - changed[:, 1].min()
    assert right > left, "its heading is to the right"


def test_robots_off_the_map_change_nothing() -> None:
    assert np.array_equal(picture(tb1=Pose2D(30.0, 3.0)), picture())


def test_lines_are_at_round_numbers_of_metres() -> None:
    drawn = picture()
    faint = (drawn == FAINT).all(axis=-1)
    columns = np.flatnonzero(faint[5:150].mean(axis=0) > 0.9)
    assert columns.tolist() == [0, 100, 200, 300, 400][: len(columns)]
    rows = np.flatnonzero(faint[:, 30:].mean(axis=1) > 0.8)
    assert rows.tolist() == [0, 100], "y = 4 and 3 m"


def test_zones_are_coloured() -> None:
    ring = [[0.0, 2.5], [1.0, 2.5], [1.0, 3.5], [0.0, 3.5], [0.0, 2.5]]
    feature = {
        "type": "Feature",
        "geometry": {"type": "Polygon", "coordinates": [ring]},
        "properties": {"kind": "keep_out", "name": "pit"},
    }
    zones = json.dumps({"type": "FeatureCollection", "features": [feature]}).encode()
    plain, drawn = picture(), picture(zones)
    assert drawn.shape == plain.shape
    assert not np.array_equal(drawn[80:120, 120:180], plain[80:120, 120:180])
    assert np.array_equal(drawn[:, 250:], plain[:, 250:])
