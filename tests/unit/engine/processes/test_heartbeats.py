"""Who misses beats is frozen; who is new, has gone, or could not be looked at is not."""

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
    return heartbeats.look(beats)


def test_who_beats_late_but_beats_lives(heartbeats: Heartbeats, clock: ManualClock) -> None:
    for number in range(50):
        assert look(heartbeats, clock, {"slow": 1 + number // MISSED}) == []


def test_who_misses_as_many_beats_as_are_forgiven_is_frozen_and_the_others_are_not(
    heartbeats: Heartbeats, clock: ManualClock
) -> None:
    look(heartbeats, clock, {"stuck": 7, "well": 7})
    looks = [look(heartbeats, clock, {"stuck": 7, "well": 8 + n}) for n in range(MISSED)]
    assert looks == [[]] * (MISSED - 1) + [["stuck"]]


def test_who_froze_before_its_first_beat_is_frozen(heartbeats: Heartbeats, clock: ManualClock) -> None:
    looks = [look(heartbeats, clock, {"new": 0}) for _ in range(MISSED + 1)]
    assert looks == [[]] * MISSED + [["new"]]


def test_after_a_sleep_of_our_own_nobody_is_blamed(heartbeats: Heartbeats, clock: ManualClock) -> None:
    look(heartbeats, clock, {"a": 1})
    for _ in range(MISSED - 1):
        assert look(heartbeats, clock, {"a": 1}) == []
    assert look(heartbeats, clock, {"a": 1}, after=3600.0) == []
    assert [look(heartbeats, clock, {"a": 1}) for _ in range(MISSED)] == [[]] * (MISSED - 1) + [["a"]]


def test_who_went_and_came_again_by_the_same_name_is_new(heartbeats: Heartbeats, clock: ManualClock) -> None:
    for _ in range(MISSED):
        look(heartbeats, clock, {"a": 5})
    look(heartbeats, clock, {})
    assert look(heartbeats, clock, {"a": 5}) == []


def test_with_more_looks_in_a_period_nobody_is_blamed_earlier(clock: ManualClock) -> None:
    heartbeats = Heartbeats(clock, looks=2)
    half = BEAT_PERIOD / 2.0
    look(heartbeats, clock, {"stuck": 7}, half)
    looks = [look(heartbeats, clock, {"stuck": 7}, half) for _ in range(2 * MISSED)]
    assert looks == [[]] * (2 * MISSED - 1) + [["stuck"]]
