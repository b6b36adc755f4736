"""Connected components of free space."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.maps.free_space import reachable
from ppaas.maps.kernels import components as kernels
from tests.reference.maps import maps as twin
from tests.support.world.maps import occupied_arrays, real_map


@given(occupied_arrays(), st.data())
def test_reachable_cells_agree_with_the_twin(occupied, draw):
    free = occupied == 0
    row = draw.draw(st.integers(0, free.shape[0] - 1))
    column = draw.draw(st.integers(0, free.shape[1] - 1))
    assert np.array_equal(reachable(free, row, column), twin.reachable(free, row, column))


def test_a_diagonal_gap_is_not_passable():
    assert reachable(np.array([[True, False], [False, True]]), 0, 0).tolist() == [[True, False], [False, False]]


def test_no_cell_is_reachable_from_an_obstacle():
    assert not reachable(np.array([[False, True]]), 0, 0).any()


def test_strided_view_of_an_array_is_accepted():
    free = np.ones((6, 6), np.bool_)
    free[:, 3] = False
    assert reachable(free[1:5, ::2], 0, 0).all()


@pytest.mark.parametrize(("row", "column"), [(-1, 0), (0, -1), (2, 0), (0, 3)])
def test_a_cell_outside_is_refused(row, column):
    with pytest.raises(InvalidInput, match="outside"):
        reachable(np.ones((2, 3), np.bool_), row, column)


@pytest.mark.parametrize("free", [np.ones((2, 2), np.uint8), np.ones(4, np.bool_)])
def test_array_that_is_not_a_bool_grid_is_refused(free):
    with pytest.raises(InvalidMap, match="bools"):
        reachable(free, 0, 0)


def test_free_space_of_a_real_map_is_mostly_connected(data):
    free = real_map(data, "turtlebot3").data == 0
    row, column = np.argwhere(free)[len(np.argwhere(free)) // 2].tolist()
    assert reachable(free, row, column).sum() > 0.5 * free.sum()


def test_warm_calls_the_kernel():
    kernels.warm()
    assert kernels.flood.nopython_signatures
