"""The heap behaves like a sorted list of keys from which any cell may be removed."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.planners.kernels.indexed_heap import drop, put

CELLS = 12
ORDERS = st.lists(st.tuples(st.integers(0, CELLS - 1), st.none() | st.tuples(st.integers(0, 4), st.integers(0, 4))))


@given(ORDERS)
def test_first_key_is_always_the_smallest(orders):
    keys, cells, places = np.zeros((CELLS + 2, 2)), np.zeros(CELLS + 2, np.int32), np.zeros(CELLS, np.int32)
    size, twin = 0, {}
    for cell, key in orders:
        if key is None:
            size = drop(keys, cells, places, size, cell)
            twin.pop(cell, None)
        else:
            size = put(keys, cells, places, size, cell, float(key[0]), float(key[1]))
            twin[cell] = key
        assert size == len(twin)
        assert {int(c): tuple(k) for c, k in zip(cells[1 : size + 1], keys[1 : size + 1], strict=True)} == twin
        assert all(cells[places[c]] == c for c in twin)
        assert not twin or tuple(keys[1]) == min(twin.values())
        assert np.count_nonzero(places) == size
