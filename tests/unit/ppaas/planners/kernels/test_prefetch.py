"""What is told to come soon changes nothing, wherever it lies."""

import numpy as np
import pytest
from numba import njit

from ppaas.planners.kernels.prefetch import fetch, fetch_close


@njit
def _sum_up(numbers, ahead):
    total = 0
    for i in range(len(numbers)):
        fetch(numbers, i + ahead)
        fetch_close(numbers, i + ahead)
        total += numbers[i]
    return total


@pytest.mark.parametrize("ahead", [0, 5, 10**12, -(10**12)])
def test_numbers_are_what_they_were_and_no_place_is_refused(ahead):
    numbers = np.arange(100, dtype=np.int32)
    numbers.flags.writeable = False
    assert _sum_up(numbers, np.int64(ahead)) == 4950
