"""Distances agree with their slow twin."""

import numpy as np
from hypothesis import given

from ppaas.fleet.kernels import distances as module
from ppaas.fleet.kernels.board import UNREACHABLE
from ppaas.fleet.problem import distances_from
from tests.reference.fleet.searches import distances
from tests.support.fleet.halls import Hall, halls, ruled_halls


@given(halls(most_cells=30) | ruled_halls(most_cells=30))
def test_distances_are_the_numbers_of_moves(hall: Hall) -> None:
    found = distances_from(hall.roadmap, np.array(hall.goals, np.int32))
    assert found.tolist() == [distances(hall.roadmap, goal) for goal in hall.goals]


def test_a_distance_that_does_not_fit_is_told() -> None:
    cells = int(UNREACHABLE) + 1
    neighbours = np.full((cells, 4), -1, np.int32)
    neighbours[:, 0], neighbours[:, 1] = np.arange(cells) - 1, np.arange(cells) + 1
    neighbours[0] = [1, -1, -1, -1]
    neighbours[-1, 1] = -1
    out, queue = np.empty(cells, np.int16), np.empty(cells, np.int32)
    assert not module.flood(neighbours, 0, out, queue)
    assert module.flood(neighbours, 1, out, queue)
    assert out.max() == UNREACHABLE - 1
