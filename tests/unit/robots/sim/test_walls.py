import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.typing import NDArray

from robots.sim.walls import merge_rectangles

GRIDS = arrays(np.bool_, array_shapes(min_dims=2, max_dims=2, min_side=1, max_side=12), elements=st.booleans())


@given(GRIDS)
def test_rectangles_cover_each_occupied_cell_exactly_once(occupied: NDArray[np.bool_]) -> None:
    covered = np.zeros(occupied.shape, int)
    for left, bottom, right, top in merge_rectangles(occupied):
        assert left < right
        assert bottom < top
        covered[bottom:top, left:right] += 1
    assert (covered == occupied).all()


def test_a_block_and_a_straight_wall_are_one_rectangle() -> None:
    occupied = np.zeros((8, 9), bool)
    occupied[1:4, 2:6] = True
    assert merge_rectangles(occupied).tolist() == [[2, 1, 6, 4]]
    assert len(merge_rectangles(np.ones((1, 100), bool))) == 1
    assert len(merge_rectangles(np.ones((100, 1), bool))) == 1
