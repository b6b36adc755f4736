"""Distances around new obstacles are those of the transform of the whole grid."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from ppaas.costmap.kernels.near_obstacles import FEW, are_few, lower_near, reach_in_cells
from ppaas.maps.kernels.distance import distance_serial

shapes = st.tuples(st.integers(1, 24), st.integers(1, 24))


@given(
    masks=shapes.flatmap(lambda shape: st.tuples(*[hnp.arrays(np.bool_, shape, fill=st.just(False))] * 2)),
    reach=st.integers(0, 12),
)
def test_distances_are_those_to_all_obstacles_as_far_as_they_reach(
    masks: tuple[NDArray[np.bool_], NDArray[np.bool_]], reach: int
) -> None:
    known, new = masks
    distance = distance_serial(known.view(np.uint8), 0.05)
    lower_near(new.view(np.uint8), 0.05, reach, distance)
    expected = distance_serial((known | new).view(np.uint8), 0.05)
    near = expected <= 0.05 * reach + 1e-6
    np.testing.assert_allclose(distance[near], expected[near], rtol=3e-7)
    assert (distance[~near] > 0.05 * reach + 1e-6).all()
    assert ((distance == 0.0) == (expected == 0.0)).all()


def test_many_obstacles_are_left_to_the_transform_of_the_whole_grid() -> None:
    new = np.zeros((60, 60), np.bool_)
    assert are_few(new, 11)
    new[:10] = True
    assert FEW * new.size < 600 * 23**2
    assert not are_few(new, 11)


def test_distances_are_exact_up_to_the_last_cell_with_costs() -> None:
    assert [reach_in_cells(distance, 0.05) for distance in (0.0, 0.05, 0.549, 0.55)] == [1, 2, 11, 12]
