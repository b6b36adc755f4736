"""Kernels that are compiled for one thread and for many stay apart in numba's cache on disk."""

from typing import Any

import pytest
from numba import njit

from ppaas.costmap.kernels import inflation
from ppaas.maps.kernels import distance
from ppaas.maps.kernels.serial import serial_copy


def twice(number: int) -> int:
    return 2 * number


def index_file(kernel: Any) -> str:
    """Return the file of the cache that lists what was compiled of a kernel."""
    return str(vars(kernel)["_cache"]._cache_file._index_path)


@pytest.mark.parametrize(
    ("serial", "parallel"),
    [
        (distance.distance_serial, distance.distance_parallel),
        (inflation.inflate_serial, inflation.inflate_parallel),
    ],
)
def test_serial_and_parallel_kernels_have_separate_cache_entries(serial, parallel):
    assert index_file(serial) != index_file(parallel)


def test_without_a_copy_a_serial_and_a_parallel_kernel_share_their_cache_entries():
    parallel = njit(cache=True, parallel=True)(twice)
    assert index_file(njit(cache=True)(twice)) == index_file(parallel)
    assert index_file(njit(cache=True)(serial_copy(twice))) != index_file(parallel)
