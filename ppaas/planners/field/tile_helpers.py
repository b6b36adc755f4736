"""Threads that help with fields of tiles: they sleep and work without Python, so nobody waits for the interpreter."""

import atexit
import os
import threading
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ppaas.planners.field.kernels.tile_help import BOX, HEARS, OVER, RINGS
from ppaas.planners.field.kernels.tile_service import serve
from ppaas.planners.helper_threads import HelperThreads

Ints = NDArray[np.int64]

LONGEST_GOODBYE = 1.0
"""How long a process that ends waits for one of them to leave [s]."""


class FieldHelpers:
    """Threads that are started as they are needed, one for each CPU at most.

    See `ppaas.planners.field.kernels.tile_help` for how they are called.
    """

    def __init__(self) -> None:
        self._boxes = np.zeros((os.cpu_count() or 1, BOX), np.int64)
        self._threads: list[threading.Thread] = []
        self._placed = HelperThreads()
        self._starting = threading.Lock()

    def boxes(self, count: int) -> Ints:
        """Return the boxes of so many helpers, if there are as many, that wake on other CPUs than the caller's."""
        count = min(count, len(self._boxes))
        if count > 0:
            if len(self._threads) < count:
                self._start(count)
            self._placed.keep_off()
        return self._boxes[: max(count, 0)]

    def _start(self, count: int) -> None:
        with self._starting:
            for box in self._boxes[len(self._threads) : count]:
                box[HEARS], box[RINGS] = os.pipe()
                os.set_blocking(int(box[RINGS]), False)
                enlisted = threading.Event()
                thread = threading.Thread(target=self._help, args=(box, enlisted), name="field", daemon=True)
                thread.start()
                enlisted.wait()
                self._threads.append(thread)

    def _help(self, box: Ints, enlisted: threading.Event) -> None:
        self._placed.enlist()
        enlisted.set()
        serve(box, self._boxes[:0])

    def close(self) -> None:
        """End all threads."""
        for box, thread in zip(self._boxes, self._threads, strict=False):
            box[OVER] = 1
            os.write(int(box[RINGS]), b"!")
            thread.join(LONGEST_GOODBYE)

    def forget(self) -> None:
        """Close the pipes of threads that there are none of in this process, which was forked."""
        for box in self._boxes[: len(self._threads)]:
            os.close(int(box[HEARS]))
            os.close(int(box[RINGS]))
        self._threads.clear()


def boxes_for(threads: int) -> Ints:
    """Return the boxes of those who may help one thread, so that so many work at most; see `FieldHelpers.boxes`."""
    return _helpers().boxes(threads - 1)


@cache
def _helpers() -> FieldHelpers:
    helpers = FieldHelpers()
    atexit.register(helpers.close)
    return helpers


def _begin_anew() -> None:
    if _helpers.cache_info().currsize:
        _helpers().forget()
        _helpers.cache_clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_begin_anew)
