"""How planners are timed: the least of several runs, with what numba's compiler takes told apart."""

import contextlib
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TypeVar

from numba.core import event
from rich.progress import Progress

from ppaas.clock import monotonic
from ppaas.errors import PlanTimeout

T = TypeVar("T")

RUNS = 5
MOST_RUNS = 50
BUDGET = 4.0
"""Seconds after which something slow is not run again."""
ENOUGH = 0.4
"""Seconds for which what is quick runs more often than `RUNS` times: one of its runs tells little."""


def cpus() -> int:
    """Return how many CPUs this process may use."""
    return len(os.sched_getaffinity(0))


def on_threads(count: int | str) -> str:
    """Return how so many threads are called."""
    return f"{count} thread{'s' * (int(count) != 1)}"


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
    """Return the seconds of one run and its result; a run in which something was compiled is one before it."""
    with compilation() as compiled:
        began = monotonic()
        result = work()
        seconds = monotonic() - began
    if compiled.seconds:  # to take it off would leave the error of a long time in a short one
        del result
        began = monotonic()
        result = work()
        seconds = monotonic() - began
    return seconds, result


def least(work: Callable[[], T], budget: float = BUDGET, runs: int = RUNS) -> tuple[float, T]:
    """Return the seconds of the fastest of several runs and its result; no run begins that would pass ``budget``."""
    began = monotonic()
    seconds, result = timed(work)
    for _ in range(runs - 1):
        if monotonic() - began + seconds > budget:
            break
        del result  # its memory is the next one's
        again, result = timed(work)
        seconds = min(seconds, again)
    return seconds, result


def in_turn(ways: Mapping[str, Callable[[], object]], progress: Progress, what: str, runs: int) -> dict[str, float]:
    """Return the seconds of the fastest run of each, which take turns, so that all see the same machine.

    They turn back each time, so that none always finds the caches as the same other left them.

    Parameters
    ----------
    ways : dict of callable
    progress : Progress
    what : str
        Is shown meanwhile.
    runs : int
        Of each: fewer where they would take longer than `BUDGET`, more while all together take less than `ENOUGH`.
    """
    best, spent = dict.fromkeys(ways, float("inf")), dict.fromkeys(ways, 0.0)
    for number in progress.track(range(MOST_RUNS), description=what):
        if number >= runs and sum(spent.values()) > ENOUGH:
            break
        for name, work in list(ways.items())[:: 1 - number % 2 * 2]:
            if number and spent[name] + best[name] > BUDGET:
                continue
            seconds = timed(work)[0]
            best[name], spent[name] = min(best[name], seconds), spent[name] + seconds
    return best


def within(seconds: float) -> Callable[[], None]:
    """Return a check for a planner's work that ends it after some seconds from now, by ``PlanTimeout``."""
    end = monotonic() + seconds

    def check() -> None:
        if monotonic() > end:
            raise PlanTimeout(f"not done within {seconds:g} s")

    return check


def announce(progress: Progress, what: str) -> None:
    """Say what runs next, on a line of its own where no progress can be shown."""
    if not progress.console.is_terminal:
        progress.console.print(what, markup=False, highlight=False, soft_wrap=True)
