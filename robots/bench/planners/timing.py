"""How planners are timed: the least of several runs, with what numba's compiler takes told apart."""

import contextlib
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from numba.core import event

from ppaas.clock import monotonic

T = TypeVar("T")

RUNS = 5


def cpus() -> int:
    """Return how many CPUs this process may use."""
    return len(os.sched_getaffinity(0))


@dataclass(slots=True)
class Compilation:
    """What was compiled.

    Parameters
    ----------
    seconds : float
        That the compiler took; 0 where all kernels came from the cache on the disk.
    """

    seconds: float = 0.0


@contextlib.contextmanager
def compilation() -> Iterator[Compilation]:
    """Measure what numba's compiler takes inside; it is known at the end."""
    compiled, timer = Compilation(), event.TimingListener()  # type: ignore[no-untyped-call]
    with event.install_listener("numba:compile", timer):
        yield compiled
    if timer.done:
        compiled.seconds = float(timer.duration)


def timed(work: Callable[[], T]) -> tuple[float, T]:
    """Return the seconds of one run, less what was compiled meanwhile, and its result."""
    with compilation() as compiled:
        began = monotonic()
        result = work()
        seconds = monotonic() - began
    return max(0.0, seconds - compiled.seconds), result


def least(work: Callable[[], T], budget: float, runs: int = RUNS) -> tuple[float, T]:
    """Return the seconds of the fastest of several runs and its result; slow work runs until ``budget`` is used up."""
    began = monotonic()
    seconds, result = timed(work)
    for _ in range(runs - 1):
        if monotonic() - began > budget:
            break
        again, result = timed(work)
        seconds = min(seconds, again)
    return seconds, result
