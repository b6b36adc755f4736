"""Kernels that are compiled for one thread and for many stay apart in numba's cache on disk."""

import os
import subprocess
import sys

import pytest

from ppaas.costmap.kernels import inflation
from ppaas.maps.kernels import distance

PRINT_HITS = """
import {module} as kernels
for name in ({names}):
    kernel = getattr(kernels, name)
    print(name, sum(kernel.stats.cache_hits.values()), sum(kernel.stats.cache_misses.values()))
"""


@pytest.mark.parametrize(
    ("module", "serial", "parallel"),
    [
        (distance, "distance_serial", "distance_parallel"),
        (inflation, "inflate_serial", "inflate_parallel"),
    ],
)
def test_serial_and_parallel_kernels_have_separate_cache_entries(tmp_path, module, serial, parallel):
    script = PRINT_HITS.format(module=module.__name__, names=f"{serial!r}, {parallel!r}")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    ran = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True, timeout=150
    )
    assert ran.stdout.splitlines() == [f"{serial} 0 1", f"{parallel} 0 1"], "a new cache has neither"
