"""Compilation is told apart from what is timed."""

import numba

from robots.bench.planners import timing


def test_what_is_compiled_is_told_and_not_counted() -> None:
    @numba.njit
    def kernel(x: float) -> float:
        return x + 1.0

    with timing.compilation() as first:
        kernel(1.0)
    with timing.compilation() as again:
        kernel(1.0)
    assert first.seconds > 0.0 == again.seconds


def test_the_least_of_several_runs_counts_and_slow_work_is_not_repeated() -> None:
    runs: list[int] = []
    seconds, result = timing.least(lambda: runs.append(1) or len(runs), budget=60.0)
    assert (len(runs), result) == (timing.RUNS, timing.RUNS)
    assert seconds >= 0.0
    timing.least(lambda: runs.append(1), budget=-1.0)
    assert len(runs) == timing.RUNS + 1
