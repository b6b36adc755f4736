"""Roadmaps of grids: cells, their neighbours, and errors for places where no robot may stand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from ppaas.errors import InvalidInput
from ppaas.fleet.roadmap import Roadmap
from tests.support.fleet.halls import Hall, halls, ruled_halls


@given(halls(most_cells=30))
def test_neighbours_are_the_free_cells_beside_a_cell_and_each_is_a_neighbour_of_its_neighbours(hall: Hall) -> None:
    roadmap = hall.roadmap
    for cell, own in enumerate(roadmap.neighbours):
        found = {int(near) for near in own if near >= 0}
        beside = np.abs(roadmap.cells - roadmap.cells[cell]).sum(axis=1) == 1
        assert found == set(np.nonzero(beside)[0].tolist())
        assert (own[len(found) :] == -1).all()
        assert all(cell in roadmap.neighbours[near] for near in found)


@given(ruled_halls(most_cells=30))
def test_incoming_moves_are_the_moves_of_others(hall: Hall) -> None:
    outward = {(cell, int(near)) for cell, own in enumerate(hall.roadmap.neighbours) for near in own if near >= 0}
    inward = {(int(near), cell) for cell, own in enumerate(hall.roadmap.incoming) for near in own if near >= 0}
    assert outward == inward
    for own in (*hall.roadmap.neighbours, *hall.roadmap.incoming):
        assert (np.diff((own >= 0).astype(int)) <= 0).all(), "−1 is behind the last one"


@given(st.data(), st.integers(1, 4), st.integers(1, 4))
def test_of_all_moves_between_free_cells_only_those_exist_that_are_given(data: st.DataObject, h: int, w: int) -> None:
    free, in_rows, in_columns = (data.draw(masks(*shape)) for shape in ((h, w), (h, w - 1), (h - 1, w)))
    roadmap = Roadmap.of_moves(free, in_rows, in_columns)
    expected: dict[int, set[int]] = {cell: set() for cell in range(len(roadmap))}
    for exists, (down, right) in ((in_rows, (0, 1)), (in_columns, (1, 0))):
        for row, column in np.argwhere(exists & free[: h - down, : w - right] & free[down:, right:]):
            here, there = int(roadmap.numbers[row, column]), int(roadmap.numbers[row + down, column + right])
            expected[here].add(there)
            expected[there].add(here)
    for cell, own in enumerate(roadmap.neighbours):
        count = len(expected[cell])
        assert set(own[:count].tolist()) == expected[cell]
        assert (own[count:] == -1).all()


def masks(height: int, width: int) -> st.SearchStrategy[NDArray[np.bool_]]:
    size = height * width
    return st.lists(st.booleans(), min_size=size, max_size=size).map(
        lambda bits: np.array(bits, np.bool_).reshape(height, width)
    )


@pytest.mark.parametrize(
    ("place", "text"),
    [
        ((0, 1), "the goal of robot 1, row 0 column 1, is blocked"),
        ((2, 0), "is outside the map of 2 rows and 2 columns"),
        ((0, -1), "is outside"),
    ],
)
def test_a_place_where_no_robot_may_stand_is_named(place: tuple[int, int], text: str) -> None:
    roadmap = Roadmap.of_grid(np.array([[True, False], [True, True]]))
    with pytest.raises(InvalidInput, match=text):
        roadmap.at(np.array([(0, 0), place]), "goal")
