"""Time that the calling thread has spent on compiling kernels, which counts against no time limit of a plan."""

import threading

from numba.core import event

from ppaas.clock import monotonic


class _CompileTime(event.Listener, threading.local):
    """Stopwatch of each thread that runs while numba compiles in it."""

    def __init__(self) -> None:
        self.depth = 0
        self.began = 0.0
        self.total = 0.0

    def on_start(self, _event: event.Event) -> None:
        """Start the watch, unless this compilation is part of another one."""
        if self.depth == 0:
            self.began = monotonic()
        self.depth += 1

    def on_end(self, _event: event.Event) -> None:
        """Stop the watch at the end of the outermost compilation."""
        self.depth -= 1
        if self.depth == 0:
            self.total += monotonic() - self.began


_compile_time = _CompileTime()
event.register("numba:compile", _compile_time)  # type: ignore[no-untyped-call]


def compile_seconds() -> float:
    """Return the time that the calling thread has spent on compiling kernels since this module was imported [s]."""
    return _compile_time.total
