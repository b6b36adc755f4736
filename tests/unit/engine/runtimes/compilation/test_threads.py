"""How many threads kernels use, as a container's size changes."""

import threading

import numba

from engine.runtimes.compilation.threads import KernelThreads

MOST = vars(numba.config)["NUMBA_NUM_THREADS"]


def in_a_thread(threads: KernelThreads) -> tuple[int, int]:
    found: list[tuple[int, int]] = []
    thread = threading.Thread(target=lambda: found.append((threads(), numba.get_num_threads())))
    thread.start()
    thread.join()
    return found[0]


def test_whoever_asks_is_held_to_what_holds_now() -> None:
    threads = KernelThreads(1)
    assert in_a_thread(threads) == (1, 1)
    threads.count = MOST + 1
    assert in_a_thread(threads) == (MOST + 1, MOST)
