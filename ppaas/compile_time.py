"""Time that a thread spends on compiling kernels, which counts against no time limit of a plan."""

from collections.abc import Callable
from contextvars import ContextVar
from typing import NamedTuple

from numba.core import event

from ppaas.clock import monotonic


class _Compiled(NamedTuple):
    """Compilations of one thread: how many are in progress, and start and end of each outermost one [s]."""

    depth: int = 0
    began: float = 0.0
    ended: tuple[tuple[float, float], ...] = ()


_NOTHING = _Compiled()
_compiled = ContextVar("compile_time", default=_NOTHING)


class _CompileTime(event.Listener):
    """Records when a thread compiles."""

    def on_start(self, _event: event.Event) -> None:
        """Record the start, unless this compilation is part of another one."""
        depth, began, ended = _compiled.get()
        _compiled.set(_Compiled(depth + 1, began if depth else monotonic(), ended))

    def on_end(self, _event: event.Event) -> None:
        """Record the end of the outermost compilation."""
        depth, began, ended = _compiled.get()
        _compiled.set(_Compiled(depth - 1, began, ended if depth > 1 else (*ended, (began, monotonic()))))


event.register("numba:compile", _CompileTime())  # type: ignore[no-untyped-call]


def compile_stopwatch() -> Callable[[], float]:
    """Return a function that returns the time that its caller's thread has spent on compiling kernels since now [s].

    Several threads may call it, also those that compiled other kernels before.
    """
    since = monotonic()

    def seconds() -> float:
        total = 0.0
        for began, ended in reversed(_compiled.get().ended):
            if ended <= since:
                break
            total += ended - max(began, since)
        return total

    return seconds
