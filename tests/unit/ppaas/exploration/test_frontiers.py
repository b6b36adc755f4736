"""Frontiers: every free cell beside an unknown one is in exactly one, and none is left where all is known."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ppaas.exploration.frontiers import beside_unknown, find_frontiers, known_area
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import reachable
from ppaas.maps.grid import FREE, UNKNOWN, GridInfo, GridMap

CELLS = arrays(
    np.int8, st.tuples(st.integers(1, 12), st.integers(1, 12)), elements=st.sampled_from((UNKNOWN, UNKNOWN, 0, 0, 100))
)


def grid(cells, theta: float = 0.0) -> GridMap:
    data = np.array(cells, np.int8)
    return GridMap(data, GridInfo(0.1, data.shape[1], data.shape[0], Pose2D(0.0, 0.0, theta)))


def naive_frontier_cells(data) -> set[tuple[int, int]]:
    height, width = data.shape
    return {
        (row, column)
        for row in range(height)
        for column in range(width)
        if 0 <= data[row, column] < 65
        and any(
            0 <= r < height and 0 <= c < width and data[r, c] == UNKNOWN
            for r, c in ((row - 1, column), (row + 1, column), (row, column - 1), (row, column + 1))
        )
    }


@given(CELLS)
def test_every_free_cell_beside_an_unknown_one_is_in_exactly_one_frontier(cells):
    listed = [tuple(cell) for frontier in find_frontiers(grid(cells)) for cell in frontier.cells.tolist()]
    assert len(listed) == len(set(listed))
    assert set(listed) == naive_frontier_cells(cells)


@given(CELLS)
def test_cells_that_touch_are_in_one_frontier_and_others_are_not(cells):
    frontiers = [set(map(tuple, frontier.cells.tolist())) for frontier in find_frontiers(grid(cells))]
    around = [(r, c) for r in (-1, 0, 1) for c in (-1, 0, 1)]
    for index, frontier in enumerate(frontiers):
        grown = {(row + r, column + c) for row, column in frontier for r, c in around}
        assert not any(grown & other for at, other in enumerate(frontiers) if at != index)
        reached, waiting = set(), [next(iter(frontier))]
        while waiting:
            row, column = waiting.pop()
            reached.add((row, column))
            near = {(row + r, column + c) for r, c in around}
            waiting.extend((near & frontier) - reached)
        assert reached == frontier


@given(CELLS)
def test_no_frontier_is_left_exactly_if_all_reachable_free_cells_have_known_neighbours(cells):
    free = cells == FREE
    for row, column in np.argwhere(free)[:1]:
        part = reachable(free, int(row), int(column))
        known = np.where(part | ~free, cells, np.int8(100))  # other free places count as walls
        left = find_frontiers(grid(known))
        assert (not left) == (not (part & beside_unknown(grid(cells))).any())


def test_largest_frontier_is_first_and_small_ones_are_left_out():
    cells = np.full((20, 20), 0, np.int8)
    cells[:, 15:] = UNKNOWN
    cells[5, 5] = UNKNOWN
    first, second = find_frontiers(grid(cells))
    assert (first.size, second.size) == (pytest.approx(2.0), pytest.approx(0.4))
    assert [frontier.size for frontier in find_frontiers(grid(cells), 0.5)] == [first.size]
    assert len(find_frontiers(grid(cells), 0.4)) == 2


@pytest.mark.parametrize("theta", [0.0, 0.7])
def test_heading_is_into_the_unknown_in_the_map_frame(theta):
    cells = np.zeros((10, 10), np.int8)
    cells[8:] = UNKNOWN
    (frontier,) = find_frontiers(grid(cells, theta))
    assert frontier.heading == pytest.approx(math.pi / 2 + theta)


def test_known_map_has_no_frontier_even_at_its_border():
    assert find_frontiers(grid(np.zeros((4, 5)))) == []


def test_known_area_counts_free_and_occupied_cells():
    cells = np.full((10, 10), UNKNOWN, np.int8)
    cells[0], cells[1] = 0, 100
    assert known_area(grid(cells)) == pytest.approx(0.2)
