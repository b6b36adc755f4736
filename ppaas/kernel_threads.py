"""Whether and with how many threads a parallel kernel may be called."""

from collections.abc import Iterator
from contextlib import contextmanager

import numba
from numba import config


@contextmanager
def at_most(threads: int) -> Iterator[int]:
    """Let parallel kernels called inside use at most ``threads`` threads, and give how many they will.

    One means: call the serial kernel. So it is where numba finds no threading layer, and where it has only
    ``workqueue``, which ends the process when two threads of Python call parallel kernels at once.
    """
    allowed = min(threads, int(config.NUMBA_NUM_THREADS))  # type: ignore[attr-defined]
    if allowed < 2:
        yield 1
        return
    before = _set_threads(allowed)
    if not before:
        yield 1
        return
    try:
        yield allowed
    finally:
        numba.set_num_threads(before)


def _set_threads(threads: int) -> int:
    """Set this thread's number of threads and return the number before; 0 if kernels must stay serial."""
    try:
        before = int(numba.get_num_threads())
    except ValueError:  # numba's way to say that no threading layer could be loaded
        return 0
    if numba.threading_layer() == "workqueue":  # type: ignore[attr-defined]
        return 0
    numba.set_num_threads(threads)
    return before
