"""Clocks of robots, and trust in them."""

import pytest

from ppaas.people.coordinator.group import ALONE, LATENCY, OLDEST, WALLS, RobotClock, TrustRecord

NOW = 1_700_000_000.0


@pytest.mark.parametrize("late", [0.0, 0.1, 0.3])
def test_a_clock_that_agrees_is_believed(late: float) -> None:
    assert RobotClock().measured_at(NOW - late, NOW) == pytest.approx(NOW - late)


@pytest.mark.parametrize("ahead", [0.5, -0.5, 100.0])
def test_a_clock_that_is_off_is_corrected_by_the_least_delay(ahead: float) -> None:
    clock = RobotClock()
    for step, delay in enumerate((0.1, 0.3, 0.15)):
        measured = clock.measured_at(NOW + step - delay + ahead, NOW + step)
    assert measured == pytest.approx(NOW + 2.0 - delay + 0.1 - LATENCY, abs=0.01)


def test_no_measurement_is_of_the_future_or_too_old() -> None:
    clock = RobotClock()
    clock.measured_at(NOW, NOW)
    assert clock.measured_at(NOW - 50.0, NOW + 1.0) == NOW + 1.0 - OLDEST
    assert clock.measured_at(NOW + 1.01, NOW + 1.0) == NOW + 1.0


def judged(*, confirmed: int, denied: int, witnesses: list[str], reliable: set[str]) -> TrustRecord:
    record = TrustRecord()
    for _ in range(50):
        record.forget(0.2)
        record.compare(0.2, confirmed=confirmed, denied=denied, witnesses=witnesses)
        record.judge(reliable)
    return record


def test_a_robot_whose_people_two_others_deny_is_not_trusted() -> None:
    assert judged(confirmed=0, denied=1, witnesses=["b", "c"], reliable=set()).reason == ALONE


def test_the_word_of_one_other_is_not_enough_unless_it_is_reliable() -> None:
    assert judged(confirmed=0, denied=1, witnesses=["b"], reliable=set()).trusted
    assert judged(confirmed=0, denied=1, witnesses=["b"], reliable={"b"}).reason == ALONE


def test_a_robot_whose_people_others_confirm_is_trusted_and_reliable() -> None:
    record = judged(confirmed=2, denied=1, witnesses=["b", "c"], reliable=set())
    assert record.trusted and record.reliable


def test_trust_comes_back_when_others_confirm_its_people() -> None:
    record = judged(confirmed=0, denied=1, witnesses=["b", "c"], reliable=set())
    for _ in range(100):
        record.forget(0.2)
        record.compare(0.2, confirmed=1, denied=0, witnesses=[])
        record.judge(set())
    assert record.trusted


def test_people_behind_walls_for_long_are_not_believed() -> None:
    record = TrustRecord()
    record.see(9.0, walled=1, clear=0)
    record.judge(set())
    assert record.reason == WALLS
