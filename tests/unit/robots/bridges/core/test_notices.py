"""Notices: each fault is logged once, however its numbers change."""

import pytest

from robots.bridges.core.notices import Notices, without_numbers


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
