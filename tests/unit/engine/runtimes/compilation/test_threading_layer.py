import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.sources import ROOT


def run(*arguments: str, cache: Path) -> list[str]:
    environment = {"PATH": "", "NUMBA_CACHE_DIR": str(cache)}
    command = [sys.executable, *arguments]
    done = subprocess.run(command, check=False, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout.split(maxsplit=2)


def has_tbb() -> bool:
    code = "from engine.runtimes.compilation import threading_layer as t; print(t._load_tbb())"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True, text=True)
    return done.stdout == "True\n"


@pytest.fixture(scope="module")
def compiled_for_threads(tmp_path_factory):
    """Return what the script prints with threads, and the cache with the code compiled for them."""
    cache = tmp_path_factory.mktemp("threads")
    return run("-m", "tests.support.engine.threaded_kernels", cache=cache), cache


def test_tbb_lets_two_threads_call_parallel_kernels_at_once(compiled_for_threads):
    if not has_tbb():
        pytest.skip("no TBB for this platform")
    (layer, _, rest), _ = compiled_for_threads
    assert (layer, rest) == ("tbb", "[True, True] 2\n")


def test_kernels_run_serially_without_tbb(tmp_path):
    for _ in range(2):  # compiled, and from the cache
        layer, threads, rest = run("-m", "tests.support.engine.threaded_kernels", "without-tbb", cache=tmp_path)
        assert (layer, threads, rest) == ("serial", "1", "[True, True] 2\n")


def test_code_compiled_for_threads_is_not_used_serially(compiled_for_threads):
    _, cache = compiled_for_threads
    layer, _, rest = run("-m", "tests.support.engine.threaded_kernels", "without-tbb", cache=cache)
    assert (layer, rest) == ("serial", "[True, True] 2\n")


def test_choosing_a_layer_after_numba_is_an_error():
    code = "import numba; from engine.runtimes.compilation import threading_layer as t; t.choose()"
    done = subprocess.run([sys.executable, "-c", code], check=False, cwd=ROOT, capture_output=True, text=True)
    assert "numba is imported already; choose the threading layer before" in done.stderr
