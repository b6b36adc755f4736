"""Discs in a grid."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.maps.discs import stamp_disc
from tests.support.world.maps import sides

PLACES = st.one_of(st.integers(-6, 16).map(float), st.floats(-6.0, 16.0))


@given(sides(12), PLACES, PLACES, st.floats(0.0, 8.0))
def test_stamp_disc_writes_cells_within_the_radius_and_the_middle(shape, x, y, radius):
    cells = np.zeros(shape, np.uint8)
    stamp_disc(cells, x, y, radius, 7)
    for row, column in np.ndindex(*shape):
        off = math.hypot(column + 0.5 - x, row + 0.5 - y)
        if (row, column) == (math.floor(y), math.floor(x)) or off < radius - 1e-9:
            assert cells[row, column] == 7
        elif off > radius + 1e-9:
            assert cells[row, column] == 0
