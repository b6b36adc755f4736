"""Time that the calling thread has spent on compiling kernels, which counts against no time limit of a plan."""

from contextvars import ContextVar
from typing import NamedTuple

from numba.core import event

from ppaas.clock import monotonic


class _Watch(NamedTuple):
    """Stopwatch of one thread: compilations in progress, start of the outermost one, and time of earlier ones [s]."""

    depth: int = 0
    began: float = 0.0
    total: float = 0.0


_STOPPED = _Watch()
_watch = ContextVar("compile_time", default=_STOPPED)


class _CompileTime(event.Listener):
    """Runs the stopwatch of a thread while numba compiles in it."""

    def on_start(self, _event: event.Event) -> None:
        """Start the watch, unless this compilation is part of another one."""
        depth, began, total = _watch.get()
        _watch.set(_Watch(depth + 1, began if depth else monotonic(), total))

    def on_end(self, _event: event.Event) -> None:
        """Stop the watch at the end of the outermost compilation."""
        depth, began, total = _watch.get()
        _watch.set(_Watch(depth - 1, began, total if depth > 1 else total + monotonic() - began))


event.register("numba:compile", _CompileTime())  # type: ignore[no-untyped-call]


def compile_seconds() -> float:
    """Return the time that the calling thread has spent on compiling kernels since this module was imported [s]."""
    return _watch.get().total
