"""Tests of the start times of containers."""

from hypothesis import given
from hypothesis import strategies as st

from engine.control.start_times import StartTimes
from ppaas.clock import ManualClock


def test_start_time_counts_from_sending_and_age_from_the_order() -> None:
    clock = ManualClock(100.0)
    times = StartTimes(clock)
    times.order("c1")
    clock.advance(2.0)
    times.send("c1")
    assert times.is_awaited("c1") and times.took("c1") is None
    clock.advance(0.5)
    assert times.answer("c1") == 0.5
    assert times.answer("c1") is None, "a container answers once"
    assert (times.is_awaited("c1"), times.took("c1"), times.age("c1")) == (False, 0.5, 2.5)


def test_unknown_and_forgotten_containers_have_no_times() -> None:
    times = StartTimes(ManualClock(1.0))
    times.answer("stranger")
    assert (times.took("stranger"), times.age("stranger")) == (None, 0.0)
    times.order("c1")
    times.answer("c1")
    times.forget("c1")
    assert (len(times), times.took("c1"), times.is_awaited("c1")) == (0, None, False)


def test_patience_begins_again_each_time_that_a_container_waits_for_kernels() -> None:
    clock = ManualClock(100.0)
    times = StartTimes(clock)
    times.order("c1")
    clock.advance(10.0)
    assert times.patience("c1", 10.0) == 0.0
    times.postpone("c1")
    clock.advance(4.0)
    assert times.patience("c1", 10.0) == 6.0
    times.forget("c1")
    assert times.patience("c1", 10.0) == 0.0


@given(st.floats(0.0, 1e9), st.floats(1e-3, 1e3))
def test_a_container_that_waits_for_no_kernels_gets_no_patience_at_any_time(now: float, timeout: float) -> None:
    assert StartTimes(ManualClock(now)).patience("c1", timeout) == 0.0, "a rounding error would be waited for again"
