"""Offsets of clocks."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.people.clock_offsets import TOLERANCE, WINDOW, ClockOffset, corrected


@given(st.floats(-1e6, 1e6), st.lists(st.floats(0.0, 0.3), min_size=1, max_size=40))
def test_offset_is_that_of_the_message_with_the_least_delay(ahead, delays):
    offset = ClockOffset()
    for step, delay in enumerate(delays):
        now = 100.0 + 0.1 * step
        assert offset.note(now + ahead - delay, now) >= -1e-6
    assert offset.seconds == pytest.approx(-ahead + min(delays), abs=1e-6)


def test_delay_is_kept_and_an_offset_is_corrected():
    assert corrected(50.0, TOLERANCE - 0.01) == 50.0
    assert corrected(50.0, -0.5) == 49.5
    assert corrected(50.0, 0.5) == 50.5


def test_clock_that_is_set_is_followed():
    offset = ClockOffset()
    for step in range(100):
        offset.note(0.1 * step + (0.0 if step < 50 else 7.0), 0.1 * step)
    assert offset.seconds == pytest.approx(-7.0)
    for step in range(100, 100 + round(20 * WINDOW) + 1):
        offset.note(0.1 * step - 7.0, 0.1 * step)
    assert offset.seconds == pytest.approx(7.0)


def test_offset_before_a_break_is_forgotten():
    offset = ClockOffset()
    assert offset.seconds == 0.0
    offset.note(5.0, 0.0)
    offset.note(100.0, 100.0)
    assert offset.seconds == 0.0
