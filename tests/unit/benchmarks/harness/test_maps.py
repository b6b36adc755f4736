"""Maps of the benches."""

import math
from pathlib import Path

import numpy as np
import pytest

from benchmarks.harness.map_figure import FLOOR, WALL, map_figure, show_cells
from benchmarks.harness.map_figure import UNKNOWN as UNKNOWN_COLOUR
from benchmarks.harness.maps import RESOLUTION, read_map
from ppaas.errors import InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridInfo, GridMap


def test_generated_maps_need_no_file() -> None:
    assert read_map("office").data.shape != read_map("warehouse").data.shape


def test_only_lethal_cells_next_to_others_become_walls(tmp_path: Path) -> None:
    pixels = np.full((4, 6), 254, np.uint8)
    pixels[0, 0], pixels[0, 1] = 50, 253
    path = tmp_path / "costmap.pgm"
    path.write_bytes(b"P5\n6 4\n255\n" + pixels.tobytes())
    grid = read_map(str(path))
    assert grid.info.resolution == RESOLUTION
    assert grid.data[-1, :2].tolist() == [FREE, FREE]
    assert grid.data[-1, 2] == grid.data[-2, 0] == grid.data[-2, 2] == OCCUPIED
    assert grid.data[-1, 3] == grid.data[0, 0] == UNKNOWN


@pytest.mark.parametrize("name", ["nowhere.yaml", "nowhere.pgm"])
def test_a_missing_map_is_refused(name: str) -> None:
    with pytest.raises(InvalidMap, match="cannot read the map"):
        read_map(name)


def test_a_map_is_drawn_cell_by_cell() -> None:
    _, axes = map_figure(GridMap(np.array([[0, 100, -1]], np.int8), GridInfo(0.5, 3, 1, Pose2D(2.0, 1.0, 0.0))))
    assert axes.get_xlim() + axes.get_ylim() == pytest.approx((2.0, 3.5, 1.0, 1.5))
    [image] = axes.images
    assert np.asarray(image.get_array()).tolist() == [[list(FLOOR), list(WALL), list(UNKNOWN_COLOUR)]]


def test_a_rotated_grid_is_drawn_rotated_in_its_frame() -> None:
    _, axes = map_figure(GridMap(np.zeros((10, 10), np.int8), GridInfo(1.0, 10, 10)))
    info = GridInfo(0.1, 20, 10, Pose2D(1.0, 0.0, math.pi / 2))
    show_cells(axes, np.zeros((10, 20, 4), np.uint8), info, Pose2D(2.0, 3.0, 0.0))
    to_axes = axes.images[-1].get_transform() - axes.transData
    assert to_axes.transform((20.0, 0.0)) == pytest.approx((3.0, 5.0))
    assert axes.get_xlim() == (0.0, 10.0)
