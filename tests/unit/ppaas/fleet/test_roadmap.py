"""Roadmaps of grids: cells, their neighbours, and errors for places where no robot may stand."""

import numpy as np
import pytest
from hypothesis import given

from ppaas.errors import InvalidInput
from ppaas.fleet.roadmap import Roadmap
from tests.support.fleet.halls import Hall, halls


@given(halls(most_cells=30))
def test_neighbours_are_the_free_cells_beside_a_cell_and_each_is_a_neighbour_of_its_neighbours(hall: Hall) -> None:
    roadmap = hall.roadmap
    for cell, own in enumerate(roadmap.neighbours):
        found = {int(near) for near in own if near >= 0}
        beside = np.abs(roadmap.cells - roadmap.cells[cell]).sum(axis=1) == 1
        assert found == set(np.nonzero(beside)[0].tolist())
        assert (own[len(found) :] == -1).all()
        assert all(cell in roadmap.neighbours[near] for near in found)


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
