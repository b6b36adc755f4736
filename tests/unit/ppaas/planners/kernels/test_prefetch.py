"""Prefetching has no visible effect, at any index."""

import numpy as np
import pytest
from numba import njit

from ppaas.planners.kernels.prefetch import fetch, fetch_to_l2


@njit
def _sum_up(numbers, ahead):
    total = 0
    for i in range(len(numbers)):
        fetch(numbers, i + ahead)
        fetch_to_l2(numbers, i + ahead)
        total += numbers[i]
    return total


@pytest.mark.parametrize("ahead", [0, 5, 10**12, -(10**12)])
def test_prefetching_changes_no_number_and_accepts_any_index(ahead):
    numbers = np.arange(100, dtype=np.int32)
    numbers.flags.writeable = False
    assert _sum_up(numbers, np.int64(ahead)) == 4950
