"""Gaps in the messages to a robot."""

import pytest

from benchmarks.chaos.message_checks import Gap, Silences


def test_silences_before_between_and_after_control_cycles_are_measured() -> None:
    silences = Silences()
    silences.heard(1.0)
    silences.goal_sent(3.0)
    for now in (4.0, 4.25, 4.5, 6.5):
        silences.heard(now)
    silences.goal_ended(8.0)
    silences.heard(20.0)
    assert silences.gaps == [Gap(3.0, 4.0), Gap(4.5, 6.5), Gap(6.5, 8.0)]
    assert silences.gaps[1].seconds == pytest.approx(2.0)


def test_no_gap_is_recorded_if_all_cycles_are_received() -> None:
    silences = Silences()
    silences.goal_sent(0.0)
    for cycle in range(40):
        silences.heard(0.05 * cycle)
    silences.goal_ended(2.0)
    assert silences.gaps == []
