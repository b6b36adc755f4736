import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ppaas.localization.kernels import free_cells
from ppaas.maps.grid import FREE, OCCUPIED

seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_free_cells_are_found_by_index(seed):
    rng = np.random.default_rng(seed)
    data = rng.choice(np.array([FREE, OCCUPIED, -1], np.int8), (rng.integers(1, 9), rng.integers(1, 9)))
    free = np.argwhere(data == FREE)
    below = free_cells.count_free(data)
    assert below[-1] == len(free)
    numbers = np.sort(rng.integers(0, len(free), 20)) if len(free) else np.empty(0, np.int64)
    np.testing.assert_array_equal(free_cells.find_free(data, below, numbers), free[numbers])
