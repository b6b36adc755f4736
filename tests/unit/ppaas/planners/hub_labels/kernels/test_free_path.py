"""Costs of now against a path and the costs of the map; cells written eight at once."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from ppaas.planners.hub_labels.kernels import vectors
from ppaas.planners.hub_labels.kernels.free_path import is_free_along, opens
from ppaas.planners.hub_labels.kernels.path_cells import STEPS

PATH = np.array([[0, 0], [1, 1], [1, 2]], np.int32)


def touched(cells):
    """Yield the cells that must be free."""
    yield from map(tuple, cells)
    for (row, column), (next_row, next_column) in pairwise(cells):
        yield from ((row, next_column), (next_row, column))


@given(st.integers(0, 999), st.booleans())
def test_it_finds_each_closed_cell(seed, allow_unknown):
    rng = np.random.default_rng(seed)
    costs = rng.choice(np.array([0, 252, 253, 254, 255], np.uint8), (6, 7), p=[0.8, 0.05, 0.05, 0.05, 0.05])
    steps = np.clip(np.cumsum(rng.integers(-1, 2, (8, 2)), axis=0) + 2, 0, (5, 6)).astype(np.int32)
    closed = {253, 254} if allow_unknown else {253, 254, 255}
    expected = not any(costs[cell] in closed for cell in touched(steps))
    assert is_free_along(costs, steps, allow_unknown) == expected


def test_cells_beside_straight_moves_do_not_matter():
    for row, column, harmless in ((0, 1, False), (1, 0, False), (1, 1, False), (2, 2, True), (0, 2, True)):
        costs = np.zeros((3, 3), np.uint8)
        costs[row, column] = 254
        assert is_free_along(costs, PATH, False) == harmless


def test_no_path_is_free():
    assert is_free_along(np.full((3, 3), 254, np.uint8), PATH[:0], False)


@given(st.integers(0, 999), st.booleans(), st.tuples(*[st.integers(0, 4)] * 4))
def test_it_finds_whether_a_cell_of_the_window_has_opened(seed, allow_unknown, bounds):
    rng = np.random.default_rng(seed)
    now, base = rng.choice(np.array([0, 252, 253, 254, 255], np.uint8), (2, 4, 4), p=[0.1, 0.1, 0.3, 0.3, 0.2])
    base.flags.writeable = False
    top, bottom, left, right = bounds
    free_now, free_before = ((c < 253) | (allow_unknown & (c == 255)) for c in (now, base))
    expected = (free_now & ~free_before)[top:bottom, left:right].any()
    assert opens(now, base, bounds, allow_unknown) == expected


write_next = vectors.write_next


@njit
def _write(flat, at, cell):
    for direction in range(8):
        write_next(flat, at + 8 * direction, cell, STEPS, 8 * direction)


@given(st.integers(0, 10), st.integers(-(2**62), 2**62))
def test_each_written_cell_is_the_first_plus_its_step(at, cell):
    flat = np.full(80, 7)
    _write(flat, at, cell)
    assert flat[at : at + 64].tolist() == (cell + STEPS).tolist()
    assert (np.delete(flat, slice(at, at + 64)) == 7).all()
