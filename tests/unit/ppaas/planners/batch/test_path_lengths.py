"""Lengths of shortest paths between many places."""

import math

import numpy as np
import pytest

from ppaas.costmap.costmap import Costmap
from ppaas.maps.grid import GridInfo
from ppaas.planners.batch.path_lengths import PathLengths


def lengths() -> PathLengths:
    """Return lengths on 10 × 10 cells of 0.5 m, with a wall in column 5 but for its last row."""
    data = np.zeros((10, 10), np.uint8)
    data[:9, 5] = 254
    data.flags.writeable = False
    return PathLengths(Costmap(data, GridInfo(0.5, 10, 10)))


def test_lengths_are_along_the_cells() -> None:
    found = lengths().between([(0, 0), (0, 4)], [(0, 3), (3, 3), (0, 9)])
    beside = [1.5, 0.5 * 3 * math.sqrt(2.0)]
    assert found[0, :2] == pytest.approx(beside)
    assert found[1, 2] == pytest.approx(0.5 * (9 + 2 + 6 + 3 * math.sqrt(2.0)))


def test_a_place_in_a_wall_is_moved_to_the_nearest_free_cell_and_an_end_without_one_has_no_length() -> None:
    found = lengths()
    assert found.cell(2.6, 2.25) == (4, 4)
    assert found.cell(2.75, 2.25, near=0.1) is None
    assert found.cell(99.0, 0.0) is None
    assert np.isinf(found.between([(0, 0)], [None])).all()
