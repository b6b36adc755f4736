"""Parts of a bridge: the clock of the robot, and messages for the user."""

import pytest

from ppaas.clock import ManualClock
from robots.bridges.core.notices import Notices, without_numbers
from robots.bridges.core.parts import RobotTime


def test_stamps_count_on_from_those_of_the_robot() -> None:
    clock = ManualClock(10.0)
    time = RobotTime(clock, lambda: 1000.5)
    assert time.now() == {"sec": 1000, "nanosec": 500_000_000}, "the robot's clock is unknown"
    time.heard({"sec": 0, "nanosec": 0}, 10.0)
    assert time.now()["sec"] == 1000, "a stamp of zero says nothing"
    time.heard({"sec": 50, "nanosec": 250_000_000}, 10.0)
    clock.advance(2.5)
    assert time.now() == {"sec": 52, "nanosec": 750_000_000}


def test_texts_that_differ_in_numbers_alone_are_one_fault(caplog: pytest.LogCaptureFixture) -> None:
    notices = Notices()
    for number in range(5):
        notices.warn(f"late message {number} on state, {number / 4:.2f} s old (-{number})")
    assert len(caplog.records) == 1
    assert notices.recent(-1.0) == ["late message 4 on state, 1.00 s old (-4)"], "the doctor gets the newest"


@pytest.mark.parametrize("text", ["robot 'tb1'", "robot '1'", "acme/7", "version 2.1.0", "zone a-7", "tb2"])
def test_digits_of_names_are_no_numbers(text: str) -> None:
    assert without_numbers(text) == text


def test_a_number_of_notices_is_logged(caplog: pytest.LogCaptureFixture) -> None:
    notices = Notices(most=3)
    for letter in "abcdef":
        notices.warn(letter)
    assert len(caplog.records) == 3
