import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

KERNELS = """
import numba, numpy as np
@numba.njit(cache=True)
def total(values):
    return values.sum()
@numba.njit
def mean(values):
    return total(values) / len(values)
@numba.njit(cache=True)
def double(values):
    'Without this text other constants come first, and the code that loads them differs.'
    values *= 2.0
"""

CALLS = """
import sys
import numpy as np
from engine.runtimes import compiled
compiled.load_without_compiler()
import some_kernels
values = np.array([3.0, 1.0, 2.0])
print(some_kernels.total(values), len(some_kernels.total.stats.cache_hits), "numba.np.npyimpl" in sys.modules)
print(some_kernels.mean(values), "numba.np.npyimpl" in sys.modules)
some_kernels.double(values)
print(values[0], len(some_kernels.double.stats.cache_hits))
"""

TAKEN_AWAY = """
import os, pathlib
import numpy as np
from engine.runtimes import compiled
compiled.load_without_compiler()
import some_kernels
values = np.array([3.0, 1.0, 2.0])
some_kernels.total(values)
for file in pathlib.Path(os.environ["NUMBA_CACHE_DIR"]).rglob("*.nb?"):
    file.unlink()
some_kernels.mean(values)
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


def test_what_is_in_the_cache_is_loaded_without_the_compiler_and_what_calls_it_is_compiled(call):
    assert call() == ["6.0 0 True", "2.0 True", "6.0 0"]
    assert call() == ["6.0 1 False", "2.0 True", "6.0 1"]


def test_what_was_compiled_with_its_documentation_is_loaded_without(call):
    assert call()[-1] == "6.0 0"
    assert call("-OO") == ["6.0 1 False", "2.0 True", "6.0 1"]


def test_what_is_no_longer_in_the_cache_cannot_be_linked_with_and_that_is_told(call):
    call()
    with pytest.raises(subprocess.CalledProcessError) as caught:
        call(script=TAKEN_AWAY)
    assert "kernels were taken from the cache" in caught.value.stderr
