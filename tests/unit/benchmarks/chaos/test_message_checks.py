"""Repeated and old messages are errors; others are not."""

import pytest

from benchmarks.chaos.message_checks import Gap, MessageChecks


@pytest.fixture
def errors() -> list[str]:
    """Return the errors that the checks report."""
    return []


@pytest.fixture
def checks(errors: list[str]) -> MessageChecks:
    """Return the checks of robot ``r``."""
    return MessageChecks("r", errors.append)


def test_the_replacement_of_a_clone_is_no_error(checks: MessageChecks, errors: list[str]) -> None:
    for stamp in (1.0, 1.05, 1.1, 5.0, 5.05):
        checks.cycled(stamp)
    for stamp in (1.0, 1.1, 5.0):
        checks.scanned(stamp)
        checks.localized(stamp)
    assert errors == []


def test_repeated_feedback_of_a_cycle_is_an_error(checks: MessageChecks, errors: list[str]) -> None:
    for stamp in (1.0, 1.05, 1.05):
        checks.cycled(stamp)
    assert errors == ["r received the feedback of a control cycle again"]


def test_feedback_of_an_earlier_clone_is_an_error(checks: MessageChecks, errors: list[str]) -> None:
    for stamp in (1.0, 5.0, 4.9, 5.05):
        checks.cycled(stamp)
    assert errors == ["r received the feedback of a control cycle that is 0.100 s older than the last one"]


def test_two_concurrent_clones_are_an_error_without_repeated_messages(checks: MessageChecks, errors: list[str]) -> None:
    for number in range(21):
        checks.cycled(100.0 + 0.05 * number)
    assert errors == []
    for number in range(21, 41):
        checks.cycled(100.0 + 0.05 * number)
        checks.cycled(100.02 + 0.05 * number)
    assert len(errors) == 1 and "control cycles within a second" in errors[0]


def test_two_poses_of_one_scan_are_an_error(checks: MessageChecks, errors: list[str]) -> None:
    for stamp in (1.0, 1.1):
        checks.scanned(stamp)
    for stamp in (1.0, 1.1, 1.1, 1.0):
        checks.localized(stamp)
    assert errors == [
        "r received the pose of a scan again",
        "r received the pose of a scan that is 0.100 s older than the last one",
    ]


def test_a_pose_of_an_unknown_scan_is_an_error(checks: MessageChecks, errors: list[str]) -> None:
    checks.scanned(1.0)
    for stamp in (1.0, 1.000_001):
        checks.localized(stamp)
    assert errors == ["r received the pose of a scan that was never sent"]


def test_several_scans_may_have_the_same_stamp(checks: MessageChecks, errors: list[str]) -> None:
    for _ in range(2):
        checks.scanned(1.0)
    for _ in range(2):
        checks.localized(1.0)
    assert errors == []


def test_commands_are_counted_and_gaps_between_them_measured(checks: MessageChecks) -> None:
    checks.commanded(0.0)
    checks.uncommanded.goal_sent(10.0)
    for now in (10.1, 10.2, 12.2, 12.3):
        checks.commanded(now)
    checks.uncommanded.goal_ended(15.0)
    assert checks.uncommanded.gaps == [Gap(10.2, 12.2), Gap(12.3, 15.0)]
    assert checks.commands == 5 and checks.driven.is_set()
