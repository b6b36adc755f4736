"""The threading layer, and the number of kernel threads when the size of a container changes."""

import subprocess
import sys
import threading
from pathlib import Path

import numba
import pytest

from engine.runtimes.compilation.threading_layer import KernelThreads
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


MOST = vars(numba.config)["NUMBA_NUM_THREADS"]


def in_a_thread(threads: KernelThreads) -> tuple[int, int]:
    found: list[tuple[int, int]] = []
    thread = threading.Thread(target=lambda: found.append((threads(), numba.get_num_threads())))
    thread.start()
    thread.join()
    return found[0]


def test_each_call_sets_the_current_number_of_threads() -> None:
    threads = KernelThreads(1)
    assert in_a_thread(threads) == (1, 1)
    threads.count = MOST + 1
    assert in_a_thread(threads) == (MOST + 1, MOST)
