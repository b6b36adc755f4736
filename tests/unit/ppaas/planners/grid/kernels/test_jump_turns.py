"""The table of turns follows the definition of pruned neighbours."""

import numpy as np

from ppaas.planners.grid.kernels.jump_turns import ANY, DOWN, MIXED, RIGHT, turns
from tests.reference.planners import jumps as twin

CELLS = [(down, right) for down in (-1, 0, 1) for right in (-1, 0, 1)]


def neighbourhoods(*free):
    """Return all neighbourhoods in which (0, 0) and these cells are free."""
    found = (({cell for bit, cell in enumerate(CELLS) if n >> bit & 1}, n) for n in range(512))
    return [(cells, number) for cells, number in found if {(0, 0), *free} <= cells]


def directions(number):
    return {(DOWN[d], RIGHT[d]) for d in range(8) if number >> d & 1}


def test_neighbours_after_a_straight_move_follow_the_definition():
    for came in range(4):
        parent = (-DOWN[came], -RIGHT[came])
        for free, number in neighbourhoods(parent):
            assert directions(turns()[came, number]) == twin.kept_neighbours(free, parent), (came, free)


def test_neighbours_after_a_diagonal_move_follow_the_definition():
    for came in range(4, 8):
        down, right = DOWN[came], RIGHT[came]
        for free, number in neighbourhoods((-down, -right), (-down, 0), (0, -right)):
            assert directions(turns()[came, number]) == twin.kept_neighbours(free, (-down, -right)), (came, free)


def test_moves_from_the_start_cut_no_corner():
    for free, number in neighbourhoods():
        assert directions(turns()[ANY, number]) == twin.kept_neighbours(free, None)


def test_mixed_cell_keeps_all_moves_of_cheapest_paths():
    """For any weights: the previous cell reaches the cells of the dropped moves at less cost."""
    rng = np.random.default_rng(8)
    for came in range(8):
        parent = (-DOWN[came], -RIGHT[came])
        kept = set()
        for _ in range(300):
            weights = {cell: float(rng.choice([1.0, 1.1, 2.0, 5.0])) for cell in CELLS}
            kept |= twin.kept_by_weights(weights, parent)
        everywhere = 511
        assert directions(turns()[MIXED + came, everywhere]) == kept


def test_table_has_one_byte_per_entry():
    assert (turns().shape, turns().dtype) == ((17, 512), np.uint8)
