"""Eight cells written at once equal eight cells written one by one."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

from ppaas.planners.hub_labels.kernels import vectors
from ppaas.planners.hub_labels.kernels.path_cells import STEPS

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
