"""Timing of planners: minimum of several runs, without the time of numba's compiler."""

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
"""Time after which a slow call is not run again [s]."""
ENOUGH = 0.4
"""Total time up to which quick calls run more than `RUNS` times [s]."""


def cpus() -> int:
    """Return the number of CPUs that this process may use."""
    return len(os.sched_getaffinity(0))


def on_threads(count: int | str) -> str:
    """Return the name of a number of threads, such as ``2 threads``."""
    return f"{count} thread{'s' * (int(count) != 1)}"


@dataclass(slots=True)
class Compilation:
    """Compilation of kernels.

    Parameters
    ----------
    seconds : float
        Time of the compiler [s]; 0 if all kernels came from the cache on disk.
    """

    seconds: float = 0.0


@contextlib.contextmanager
def compilation() -> Iterator[Compilation]:
    """Measure the time of numba's compiler within the block; it is set at the end."""
    compiled, timer = Compilation(), event.TimingListener()  # type: ignore[no-untyped-call]
    with event.install_listener("numba:compile", timer):
        yield compiled
    if timer.done:
        compiled.seconds = float(timer.duration)


def timed(work: Callable[[], T]) -> tuple[float, T]:
    """Return the time of a run [s] and its result; a run in which numba compiled is repeated."""
    with compilation() as compiled:
        began = monotonic()
        result = work()
        seconds = monotonic() - began
    if compiled.seconds:  # subtracting it would leave the error of a long time in a short one
        del result
        began = monotonic()
        result = work()
        seconds = monotonic() - began
    return seconds, result


def least(work: Callable[[], T], budget: float = BUDGET, runs: int = RUNS) -> tuple[float, T]:
    """Return the time of the fastest of several runs [s] and its result; no run starts that would exceed ``budget``."""
    began = monotonic()
    seconds, result = timed(work)
    for _ in range(runs - 1):
        if monotonic() - began + seconds > budget:
            break
        del result  # frees its memory for the next run
        again, result = timed(work)
        seconds = min(seconds, again)
    return seconds, result


def in_turn(ways: Mapping[str, Callable[[], object]], progress: Progress, what: str, runs: int) -> dict[str, float]:
    """Return the time of the fastest run of each call [s]; calls take turns to share the state of the machine.

    The order is reversed each time, so that no call always follows the same other one.

    Parameters
    ----------
    ways : dict of callable
    progress : Progress
    what : str
        Description of the progress.
    runs : int
        Number of runs of each call: fewer if they would take longer than `BUDGET`, more while all together have taken
        less than `ENOUGH`.
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
    """Return a check that raises ``PlanTimeout`` from ``seconds`` after now on."""
    end = monotonic() + seconds

    def check() -> None:
        if monotonic() > end:
            raise PlanTimeout(f"not done within {seconds:g} s")

    return check


def announce(progress: Progress, what: str) -> None:
    """Print the next step if the output is not a terminal, on which the progress is shown."""
    if not progress.console.is_terminal:
        progress.console.print(what, markup=False, highlight=False, soft_wrap=True)
