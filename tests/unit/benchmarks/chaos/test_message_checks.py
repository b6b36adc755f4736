"""Repeated and old messages are errors; others are not."""

import pytest

from benchmarks.chaos.message_checks import MessageChecks
from benchmarks.chaos.silences import Gap


@pytest.fixture
def told() -> list[str]:
    """Return what the witness tells."""
    return []


@pytest.fixture
def witness(told: list[str]) -> MessageChecks:
    """Return a witness of robot ``r``."""
    return MessageChecks("r", told.append)


def test_a_clone_that_is_replaced_by_another_is_nothing_to_tell_of(witness: MessageChecks, told: list[str]) -> None:
    for stamp in (1.0, 1.05, 1.1, 5.0, 5.05):
        witness.cycled(stamp)
    for stamp in (1.0, 1.1, 5.0):
        witness.scanned(stamp)
        witness.localized(stamp)
    assert told == []


def test_a_cycle_that_is_heard_of_twice_is_told_of(witness: MessageChecks, told: list[str]) -> None:
    for stamp in (1.0, 1.05, 1.05):
        witness.cycled(stamp)
    assert told == ["r received the feedback of a control cycle again"]


def test_a_cycle_of_an_earlier_clone_is_told_of(witness: MessageChecks, told: list[str]) -> None:
    for stamp in (1.0, 5.0, 4.9, 5.05):
        witness.cycled(stamp)
    assert told == ["r received the feedback of a control cycle that is 0.100 s older than the last one"]


def test_two_clones_at_a_time_are_told_of_though_each_says_nothing_twice(
    witness: MessageChecks, told: list[str]
) -> None:
    for number in range(21):
        witness.cycled(100.0 + 0.05 * number)
    assert told == []
    for number in range(21, 41):
        witness.cycled(100.0 + 0.05 * number)
        witness.cycled(100.02 + 0.05 * number)
    assert len(told) == 1 and "control cycles within a second" in told[0]


def test_a_scan_that_tells_where_the_robot_is_twice_is_told_of(witness: MessageChecks, told: list[str]) -> None:
    for stamp in (1.0, 1.1):
        witness.scanned(stamp)
    for stamp in (1.0, 1.1, 1.1, 1.0):
        witness.localized(stamp)
    assert told == [
        "r received the pose of a scan again",
        "r received the pose of a scan that is 0.100 s older than the last one",
    ]


def test_a_pose_by_a_scan_that_was_never_sent_is_told_of(witness: MessageChecks, told: list[str]) -> None:
    witness.scanned(1.0)
    for stamp in (1.0, 1.000_001):
        witness.localized(stamp)
    assert told == ["r received the pose of a scan that was never sent"]


def test_a_world_that_stood_still_sends_several_scans_at_a_moment(witness: MessageChecks, told: list[str]) -> None:
    for _ in range(2):
        witness.scanned(1.0)
    for _ in range(2):
        witness.localized(1.0)
    assert told == []


def test_commands_are_counted_and_a_gap_is_time_without_one(witness: MessageChecks) -> None:
    witness.commanded(0.0)
    witness.uncommanded.goal_sent(10.0)
    for now in (10.1, 10.2, 12.2, 12.3):
        witness.commanded(now)
    witness.uncommanded.goal_ended(15.0)
    assert witness.uncommanded.gaps == [Gap(10.2, 12.2), Gap(12.3, 15.0)]
    assert witness.commands == 5 and witness.driven.is_set()
