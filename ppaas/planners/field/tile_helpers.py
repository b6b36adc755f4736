"""Helper threads of tile fields: they sleep and work inside compiled code, without the interpreter lock (GIL)."""

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

JOIN_TIMEOUT = 1.0
"""Time that an exiting process waits for each helper thread [s]."""


class FieldHelpers:
    """Helper threads of the process, started on demand, at most one per CPU.

    `ppaas.planners.field.kernels.tile_help` describes the protocol by which they are called.
    """

    def __init__(self) -> None:
        self._boxes = np.zeros((os.cpu_count() or 1, BOX), np.int64)
        self._threads: list[threading.Thread] = []
        self._placed = HelperThreads()
        self._starting = threading.Lock()

    def boxes(self, count: int) -> Ints:
        """Return the mailboxes of up to ``count`` helpers, which wake on other CPUs than the caller's."""
        count = min(count, len(self._boxes))
        if count > 0:
            if len(self._threads) < count:
                self._start(count)
            self._placed.move_off_this_cpu()
        return self._boxes[: max(count, 0)]

    def _start(self, count: int) -> None:
        with self._starting:
            for box in self._boxes[len(self._threads) : count]:
                box[HEARS], box[RINGS] = os.pipe()
                os.set_blocking(int(box[RINGS]), False)
                registered = threading.Event()
                thread = threading.Thread(target=self._help, args=(box, registered), name="field", daemon=True)
                thread.start()
                registered.wait()
                self._threads.append(thread)

    def _help(self, box: Ints, registered: threading.Event) -> None:
        self._placed.register()
        registered.set()
        serve(box, self._boxes[:0])

    def close(self) -> None:
        """End all threads."""
        for box, thread in zip(self._boxes, self._threads, strict=False):
            box[OVER] = 1
            os.write(int(box[RINGS]), b"!")
            thread.join(JOIN_TIMEOUT)

    def forget(self) -> None:
        """Close the pipes of the parent's helper threads, which do not exist in a forked process."""
        for box in self._boxes[: len(self._threads)]:
            os.close(int(box[HEARS]))
            os.close(int(box[RINGS]))
        self._threads.clear()


def boxes_for(threads: int) -> Ints:
    """Return the mailboxes of the helpers of one thread, for ``threads`` threads in total; see `FieldHelpers.boxes`."""
    return _helpers().boxes(threads - 1)


@cache
def _helpers() -> FieldHelpers:
    helpers = FieldHelpers()
    atexit.register(helpers.close)
    return helpers


def _reset_after_fork() -> None:
    if _helpers.cache_info().currsize:
        _helpers().forget()
        _helpers.cache_clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_reset_after_fork)
