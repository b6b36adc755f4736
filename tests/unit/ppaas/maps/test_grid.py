import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, InvalidMap
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import reachable
from ppaas.maps.grid import GridInfo
from ppaas.maps.kernels import components as kernels
from tests.reference.maps import maps as twin
from tests.support.world.maps import occupied_arrays, real_map

COORDINATES = st.floats(-100.0, 100.0)
INFOS = st.builds(
    GridInfo,
    st.floats(0.01, 2.0),
    st.integers(1, 60),
    st.integers(1, 60),
    st.builds(Pose2D, COORDINATES, COORDINATES, st.floats(-math.pi, math.pi)),
)


@given(INFOS, COORDINATES, COORDINATES)
def test_cell_of_agrees_with_to_cells(info, x, y):
    row, column = info.to_cells([(x, y)])[0].tolist()
    inside = 0 <= row < info.height and 0 <= column < info.width
    assert info.cell_of(x, y) == ((row, column) if inside else None)


@given(INFOS, st.data())
def test_the_centre_of_a_cell_lies_in_it(info, data):
    cell = data.draw(st.integers(0, info.height - 1)), data.draw(st.integers(0, info.width - 1))
    assert info.cell_of(*info.to_world(np.array(cell)).tolist()) == cell


@pytest.mark.parametrize("point", [(math.nan, 0.0), (0.0, math.inf), (-math.inf, 0.0), (1e308, -1e308), (-1e-9, 0.0)])
def test_a_point_outside_the_grid_has_no_cell(point):
    assert GridInfo(0.05, 10, 10).cell_of(*point) is None


@pytest.mark.parametrize("wrong", [{"resolution": 0.0}, {"resolution": math.nan}, {"width": 0}, {"height": 1 << 40}])
def test_an_invalid_grid_is_refused(wrong):
    with pytest.raises(InvalidMap):
        GridInfo(**({"resolution": 0.05, "width": 10, "height": 10} | wrong))


@given(INFOS, st.integers(-200, 200), st.integers(-200, 200), st.integers(1, 60), st.integers(1, 60))
def test_cells_of_a_grid_whose_corner_moved_by_whole_cells_coincide(info, row, column, height, width):
    corner = info.origin @ Pose2D(-column * info.resolution, -row * info.resolution)
    other = GridInfo(info.resolution, width, height, Pose2D(corner.x, corner.y, info.origin.theta))
    assert info.shift_to(other) == (row, column)
    assert other.shift_to(info) == (-row, -column)
    centres = info.to_world([(0, 0), (7, 3)])
    assert other.to_cells(centres).tolist() == [[row, column], [7 + row, 3 + column]]


@pytest.mark.parametrize(
    "other",
    [
        GridInfo(0.1, 9, 9, Pose2D(0.05, 0.0)),
        GridInfo(0.1, 9, 9, Pose2D(0.0, 0.03)),
        GridInfo(0.1, 9, 9, Pose2D(0.0, 0.0, 1e-3)),
        GridInfo(0.2, 9, 9),
    ],
)
def test_cells_of_grids_that_are_displaced_turned_or_of_another_size_do_not_coincide(other):
    assert GridInfo(0.1, 9, 9).shift_to(other) is None


def test_cells_of_large_grids_coincide_only_if_those_at_the_far_end_do():
    for off in (GridInfo(0.100001, 8192, 8192), GridInfo(0.1, 8192, 8192, Pose2D(0.0, 0.0, 9e-7))):
        assert GridInfo(0.1, 8192, 8192).shift_to(off) is None
    assert GridInfo(0.1, 8192, 8192).shift_to(GridInfo(0.1 + 1e-9, 8192, 8192)) == (0, 0)


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
