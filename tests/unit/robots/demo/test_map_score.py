"""Wrong cells of a map, against the true world."""

import numpy as np

from ppaas.geometry import Pose2D
from ppaas.maps.grid import UNKNOWN, GridInfo, GridMap
from robots.demo.scorer import wrong_cells

TRUTH = np.zeros((20, 30), np.int8)
TRUTH[:, 15:18] = 100


def grid(cells: np.ndarray, x: float = 0.0) -> GridMap:
    return GridMap(cells, GridInfo(0.1, cells.shape[1], cells.shape[0], Pose2D(x, 0.0)))


def test_map_of_the_world_is_right_even_if_it_is_one_cell_off() -> None:
    assert wrong_cells(grid(TRUTH), grid(TRUTH)) == (0, 600)
    assert wrong_cells(grid(TRUTH, 0.1), grid(TRUTH)) == (0, 600)


def test_wall_that_is_elsewhere_and_free_cells_inside_a_wall_are_wrong() -> None:
    made = np.zeros((20, 30), np.int8)
    made[:, 5] = 100
    wall, inside = 20, 20 - 2  # at the edges of the world, free cells are beside it
    assert wrong_cells(grid(made), grid(TRUTH)) == (wall + inside, 600)


def test_unknown_cells_do_not_count_and_all_is_free_outside_the_world() -> None:
    made = np.full((20, 30), UNKNOWN, np.int8)
    made[0, :4] = 0, 100, 0, 0
    assert wrong_cells(grid(made, -1.0), grid(TRUTH)) == (1, 4)
