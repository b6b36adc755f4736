"""Times exclude compilation."""

import itertools

import numba
import pytest
from rich.progress import Progress

from benchmarks.planners import timing
from ppaas.errors import PlanTimeout


def test_compile_time_is_measured_apart() -> None:
    @numba.njit
    def kernel(x: float) -> float:
        return x + 1.0

    with timing.compilation() as first:
        kernel(1.0)
    with timing.compilation() as again:
        kernel(1.0)
    assert first.seconds > 0.0 == again.seconds


def test_a_run_that_compiled_does_not_count() -> None:
    runs: list[float] = []

    @numba.njit
    def kernel(x: float) -> float:
        return x + 2.0

    def work() -> int:
        runs.append(kernel(1.0))
        return len(runs)

    seconds, result = timing.timed(work)
    assert result == 2 and 0.0 < seconds < 60.0
    assert timing.timed(work)[1] == 3


def test_the_fastest_of_several_runs_counts_and_slow_work_runs_once() -> None:
    runs: list[int] = []
    seconds, result = timing.least(lambda: runs.append(1) or len(runs), budget=60.0)
    assert (len(runs), result) == (timing.RUNS, timing.RUNS)
    assert seconds >= 0.0
    timing.least(lambda: runs.append(1), budget=-1.0)
    assert len(runs) == timing.RUNS + 1


def in_turn(functions: dict, runs: int) -> dict[str, float]:
    with Progress(disable=True) as progress:
        return timing.in_turn(functions, progress, "two ways", runs)


def test_functions_alternate_and_quick_ones_run_often() -> None:
    order: list[str] = []
    best = in_turn({"a": lambda: order.append("a"), "b": lambda: order.append("b")}, 2)
    assert order == ["a", "b", "b", "a"] * (timing.MOST_RUNS // 2) and set(best) == {"a", "b"}


def test_a_slow_function_runs_once_beside_a_quick_one(monkeypatch: pytest.MonkeyPatch) -> None:
    order: list[str] = []
    seconds = {"slow": timing.BUDGET * 0.75, "quick": 0.1}

    def timed(work: object) -> tuple[float, str]:
        order.append(str(work))
        return seconds[str(work)], ""

    monkeypatch.setattr(timing, "timed", timed)
    assert in_turn({"slow": "slow", "quick": "quick"}, 4) == seconds
    assert order == ["slow", "quick", "quick", "quick", "quick"]


def test_work_is_cancelled_after_its_time_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(timing, "monotonic", itertools.count().__next__)
    check = timing.within(1.5)
    check()
    with pytest.raises(PlanTimeout, match=r"1\.5 s"):
        check()


def test_the_next_step_is_printed_without_a_progress_bar(capsys: pytest.CaptureFixture[str]) -> None:
    with Progress(disable=True) as progress:
        timing.announce(progress, "[next]")
    assert capsys.readouterr().out == "[next]\n"
