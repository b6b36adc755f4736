"""Clock of a robot: small differences are taken for delays, large ones are corrected."""

import pytest

from ppaas.people.coordinator.group import LATENCY, OLDEST, RobotClock

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
