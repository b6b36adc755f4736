import numpy as np
import pytest

from ppaas.errors import InvalidInput
from ppaas.imports.maps.common.enclosed import closed_gaps, enclosed
from ppaas.maps.grid import GridInfo

INFO = GridInfo(1.0, 9, 5)
WALLS = np.array([[char == "#" for char in row] for row in (
    ".#######.",
    ".#..#..#.",
    ".#..#..#.",
    ".#######.",
    ".........",
)])  # fmt: skip


def test_cells_within_walls_are_enclosed():
    assert np.argwhere(enclosed(WALLS, INFO)).tolist() == [[row, column] for row in (1, 2) for column in (2, 3, 5, 6)]
    assert enclosed(WALLS, INFO, (2.5, 1.5)).sum() == 4
    assert not enclosed(np.zeros_like(WALLS), INFO).any()


def test_a_wall_at_the_border_encloses_nothing_beyond_the_map():
    half = np.zeros((5, 9), np.bool_)
    half[:, 4] = True
    assert not enclosed(half, INFO).any()


@pytest.mark.parametrize(
    ("start", "reason"), [((0.5, 0.5), "not within"), ((1.5, 0.5), "obstacle"), ((-1.0, 0.0), "outside")]
)
def test_a_place_that_is_not_within_walls_is_refused(start, reason):
    with pytest.raises(InvalidInput, match=reason):
        enclosed(WALLS, INFO, start)


def test_gaps_of_free_space_are_closed_and_walls_stay():
    free, occupied = np.ones((7, 7), np.bool_), np.zeros((7, 7), np.bool_)
    free[3, 3] = free[1, 1] = False
    occupied[1, 1] = True
    closed = closed_gaps(free, occupied)
    assert closed[3, 3] and not closed[1, 1]
    edge = np.zeros((7, 7), np.bool_)
    edge[:3] = True
    assert np.array_equal(closed_gaps(edge, np.zeros_like(edge)), edge)
