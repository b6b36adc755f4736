import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.sources import ROOT

KERNELS = """
import numba, numpy as np
@numba.njit(cache=True)
def total(values):
    return values.sum()
@numba.njit
def mean(values):
    return total(values) / len(values)
@numba.njit(cache=True)
def spread(values):
    return values.max() - total(values) / len(values)
@numba.njit(cache=True)
def double(values):
    'Without this text other constants come first, and the code that loads them differs.'
    values *= 2.0
"""

CALLS = """
import sys
import numpy as np
from engine.runtimes.memory_tuning import cached_kernels
cached_kernels.load_without_compiler()
cached_kernels.load_without_compiler()
import some_kernels
values = np.array([3.0, 1.0, 2.0])
print(some_kernels.total(values), len(some_kernels.total.stats.cache_hits), "numba.np.npyimpl" in sys.modules)
print(some_kernels.mean(values), "numba.np.npyimpl" in sys.modules)
some_kernels.double(values)
print(values[0], len(some_kernels.double.stats.cache_hits))
"""

COMPILED_ANEW = """
import os, pathlib, subprocess, sys
import numpy as np
from engine.runtimes.memory_tuning import cached_kernels
cached_kernels.load_without_compiler()
import some_kernels
values = np.array([3.0, 1.0, 2.0])
some_kernels.total(values)
for file in pathlib.Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*total*.nb?"):
    file.unlink()
anew = "import numba, numpy, some_kernels; numba.njit(lambda: 0)(); some_kernels.total(numpy.ones(3))"
subprocess.run([sys.executable, "-c", anew], check=True)
print(some_kernels.spread(values), len(some_kernels.spread.stats.cache_hits))
"""

LATER = """
import numpy as np
import some_kernels
print(some_kernels.spread(np.array([3.0, 1.0, 2.0])), len(some_kernels.spread.stats.cache_hits))
"""


@pytest.fixture
def call(tmp_path: Path):
    (tmp_path / "some_kernels.py").write_text(KERNELS)
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": f"{ROOT}:{tmp_path}"}

    def run(*options: str, script: str = CALLS) -> list[str]:
        command = [sys.executable, *options, "-c", script]
        done = subprocess.run(command, check=True, env=environment, capture_output=True, text=True)
        return done.stdout.splitlines()

    return run


def test_cached_kernels_load_without_the_compiler_and_are_callable(call):
    assert call() == ["6.0 0 True", "2.0 True", "6.0 0"]
    assert call() == ["6.0 1 False", "2.0 True", "6.0 1"]


def test_kernels_compiled_with_docstrings_are_loaded_without_them(call):
    assert call()[-1] == "6.0 0"
    assert call("-OO") == ["6.0 1 False", "2.0 True", "6.0 1"]


def test_kernels_recompiled_by_another_process_are_not_linked(call):
    call()
    assert call(script=COMPILED_ANEW) == ["1.0 0"]
    assert call(script=LATER) == ["1.0 1"]
