"""Number of kernel threads when the size of a container changes."""

import threading

import numba

from engine.runtimes.compilation.threading_layer import KernelThreads

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
