"""Changes of a map as rectangles of cells, and discs in a grid."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.maps.cell_rectangle import SIDE, Rectangle, changed_rectangles
from ppaas.maps.discs import stamp_disc
from tests.support.world.maps import sides


def test_equal_grids_have_no_changes():
    grid = np.zeros((100, 200), np.int8)
    assert changed_rectangles(grid, grid.copy(), Rectangle(0, 0, 100, 200)) == []


@pytest.mark.parametrize("seed", range(20))
def test_rectangles_cover_all_changes_once(seed):
    random = np.random.default_rng(seed)
    shape = random.integers(1, 5 * SIDE, 2)
    before = np.zeros(shape, np.int8)
    row, column = random.integers(0, shape)
    within = Rectangle(row, column, *random.integers((row, column), shape) + 1)
    after = before.copy()
    after[within.slices] = random.random(within.shape) < 10.0 ** -random.integers(1, 5)
    covered = np.zeros(shape, int)
    for rectangle in changed_rectangles(before, after, within):
        assert min(rectangle.shape) > 0
        covered[rectangle.slices] += 1
    assert covered.max() <= 1
    assert ((before == after) | (covered == 1)).all()
    covered[within.slices] = 0
    assert not covered.any()


def test_squares_side_by_side_and_above_each_other_are_joined():
    before, after = np.zeros((4 * SIDE, 4 * SIDE), np.int8), np.zeros((4 * SIDE, 4 * SIDE), np.int8)
    after[SIDE : 3 * SIDE, SIDE : 3 * SIDE] = 100
    whole = Rectangle(0, 0, *before.shape)
    assert changed_rectangles(before, after, whole) == [(SIDE, SIDE, 3 * SIDE, 3 * SIDE)]


def test_rectangles_have_changes_on_all_sides():
    before = np.zeros((200, 200), np.int8)
    after = before.copy()
    after[30:90, 70:75] = 100
    [one] = changed_rectangles(before, after, Rectangle(10, 20, 190, 190))
    assert one == (30, 70, 90, 75)


def test_a_small_change_of_a_large_map_is_small():
    before = np.zeros((8192, 8192), np.int8)
    after = before.copy()
    after[4000:4200, 3000:3200] = 100
    changes = changed_rectangles(before, after, Rectangle(3990, 2990, 4210, 3210))
    assert sum(rows * columns for rows, columns in (change.shape for change in changes)) < 0.01 * before.size


PLACES = st.one_of(st.integers(-6, 16).map(float), st.floats(-6.0, 16.0))


@given(sides(12), PLACES, PLACES, st.floats(0.0, 8.0))
def test_stamp_disc_writes_cells_within_the_radius_and_the_middle(shape, x, y, radius):
    cells = np.zeros(shape, np.uint8)
    stamp_disc(cells, x, y, radius, 7)
    for row, column in np.ndindex(*shape):
        off = math.hypot(column + 0.5 - x, row + 0.5 - y)
        if (row, column) == (math.floor(y), math.floor(x)) or off < radius - 1e-9:
            assert cells[row, column] == 7
        elif off > radius + 1e-9:
            assert cells[row, column] == 0
