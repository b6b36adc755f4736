"""Number of threads of parallel kernels."""

from collections.abc import Iterator
from contextlib import contextmanager

import numba
from numba import config


@contextmanager
def limit_threads(threads: int) -> Iterator[int]:
    """Limit the threads of the parallel kernels called in this context, and yield the number they will use.

    If it yields 1, call the serial kernel. It does so where numba finds no threading layer, and where the only layer
    is ``workqueue``, which aborts the process when two Python threads call parallel kernels at once.
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
    """Set numba's number of threads for this thread and return the previous one; 0 if kernels must stay serial."""
    try:
        before = int(numba.get_num_threads())
    except ValueError:  # no threading layer could be loaded
        return 0
    if numba.threading_layer() == "workqueue":  # type: ignore[attr-defined]
        return 0
    numba.set_num_threads(threads)
    return before
