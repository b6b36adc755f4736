"""The time that a thread spends on compiling kernels is known, and counts against no plan."""

import threading
from concurrent.futures import ThreadPoolExecutor
from contextvars import ContextVar
from typing import Any

import numba
import pytest
from numba.core import event

from ppaas import compile_time
from ppaas.clock import ManualClock
from ppaas.compile_time import compile_stopwatch
from ppaas.errors import PlanTimeout
from ppaas.geometry import Pose2D
from ppaas.planners.base import PlanRequest
from ppaas.planners.watch import Watch


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> ManualClock:
    made = ManualClock()
    monkeypatch.setattr(compile_time, "monotonic", made)
    nothing: Any = ContextVar("nothing", default=compile_time._NOTHING)
    monkeypatch.setattr(compile_time, "_compiled", nothing)  # what this thread compiled has times of another clock
    return made


class Takes(event.Listener):
    """Lets each compilation take some time."""

    def __init__(self, clock: ManualClock, seconds: float) -> None:
        self._clock, self._seconds = clock, seconds

    def on_start(self, event: event.Event) -> None:
        self._clock.advance(self._seconds)

    def on_end(self, event: event.Event) -> None: ...


def compile_one(clock: ManualClock, seconds: float) -> None:
    """Compile a kernel that calls another one: the two compilations are nested, and each takes this time."""
    inner = numba.njit(lambda number: number + 1)

    def outer(number: int) -> Any:
        return inner(number)

    with event.install_listener("numba:compile", Takes(clock, seconds)):  # type: ignore[no-untyped-call]
        assert numba.njit(outer)(1) == 2


def test_nested_compilations_count_once(clock: ManualClock) -> None:
    seconds = compile_stopwatch()
    compile_one(clock, 5.0)
    assert seconds() == pytest.approx(10.0)


def test_each_thread_has_its_own_time(clock: ManualClock) -> None:
    seconds = compile_stopwatch()
    other = threading.Thread(target=compile_one, args=(clock, 5.0))
    other.start()
    other.join()
    assert seconds() == 0.0


def test_compiling_counts_against_no_time_limit_of_a_plan(clock: ManualClock) -> None:
    request = PlanRequest(Pose2D(0.0, 0.0), Pose2D(1.0, 1.0), timeout=1.0, clock=clock)
    watch = Watch(request)
    compile_one(clock, 5.0)
    watch.check()
    assert watch.seconds() == pytest.approx(0.0)
    clock.advance(1.0)
    with pytest.raises(PlanTimeout):
        watch.check()


def test_kernels_compiled_before_a_plan_count_neither_in_its_thread_nor_in_another(clock: ManualClock) -> None:
    compile_one(clock, 50.0)
    watch = Watch(PlanRequest(Pose2D(0.0, 0.0), Pose2D(1.0, 1.0), timeout=1.0, clock=clock))
    clock.advance(0.25)
    with ThreadPoolExecutor(1) as another:
        assert another.submit(watch.seconds).result() == pytest.approx(0.25)
        another.submit(compile_one, clock, 5.0).result()
        another.submit(watch.check).result()
        later = Watch(PlanRequest(Pose2D(0.0, 0.0), Pose2D(1.0, 1.0), timeout=1.0, clock=clock))
        clock.advance(0.5)
        assert another.submit(later.seconds).result() == pytest.approx(0.5)
    assert later.seconds() == pytest.approx(0.5)
