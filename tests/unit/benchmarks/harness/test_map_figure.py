"""Figures of maps are in metres of the map frame."""

import math

import numpy as np
import pytest

from benchmarks.harness.map_figure import FLOOR, UNKNOWN as UNKNOWN_COLOUR, WALL, map_figure, show_cells
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap


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
