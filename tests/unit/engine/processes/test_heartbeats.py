"""A process that misses heartbeats is frozen; one that is new, has left, or was not checked is not."""

import pytest

from engine.processes.heartbeats import BEAT_PERIOD, MISSED, Heartbeats
from ppaas.clock import ManualClock


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def heartbeats(clock: ManualClock) -> Heartbeats:
    return Heartbeats(clock)


def look(heartbeats: Heartbeats, clock: ManualClock, beats: dict[str, int], after: float = BEAT_PERIOD) -> list[str]:
    clock.advance(after)
    return heartbeats.check(beats)


def test_late_heartbeats_are_tolerated(heartbeats: Heartbeats, clock: ManualClock) -> None:
    for number in range(50):
        assert look(heartbeats, clock, {"slow": 1 + number // MISSED}) == []


def test_only_a_process_that_misses_too_many_heartbeats_is_frozen(heartbeats: Heartbeats, clock: ManualClock) -> None:
    look(heartbeats, clock, {"stuck": 7, "well": 7})
    looks = [look(heartbeats, clock, {"stuck": 7, "well": 8 + n}) for n in range(MISSED)]
    assert looks == [[]] * (MISSED - 1) + [["stuck"]]


def test_a_process_may_freeze_before_its_first_heartbeat(heartbeats: Heartbeats, clock: ManualClock) -> None:
    looks = [look(heartbeats, clock, {"new": 0}) for _ in range(MISSED + 1)]
    assert looks == [[]] * MISSED + [["new"]]


def test_suspension_of_the_own_process_counts_no_misses(heartbeats: Heartbeats, clock: ManualClock) -> None:
    look(heartbeats, clock, {"a": 1})
    for _ in range(MISSED - 1):
        assert look(heartbeats, clock, {"a": 1}) == []
    assert look(heartbeats, clock, {"a": 1}, after=3600.0) == []
    assert [look(heartbeats, clock, {"a": 1}) for _ in range(MISSED)] == [[]] * (MISSED - 1) + [["a"]]


def test_a_process_that_returns_with_the_same_name_is_new(heartbeats: Heartbeats, clock: ManualClock) -> None:
    for _ in range(MISSED):
        look(heartbeats, clock, {"a": 5})
    look(heartbeats, clock, {})
    assert look(heartbeats, clock, {"a": 5}) == []


def test_more_checks_per_period_do_not_freeze_a_process_earlier(clock: ManualClock) -> None:
    heartbeats = Heartbeats(clock, checks=2)
    half = BEAT_PERIOD / 2.0
    look(heartbeats, clock, {"stuck": 7}, half)
    looks = [look(heartbeats, clock, {"stuck": 7}, half) for _ in range(2 * MISSED)]
    assert looks == [[]] * (2 * MISSED - 1) + [["stuck"]]
