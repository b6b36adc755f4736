import logging

import pytest

from engine.processes.occasional_log import OccasionalLog


def test_a_fault_that_repeats_is_one_line_a_period(caplog: pytest.LogCaptureFixture) -> None:
    now = [0.0]
    log = OccasionalLog(logging.getLogger("test"), period=60.0, clock=lambda: now[0])
    for now[0] in (0.0, 1.0, 2.0, 61.0, 62.0):
        log.warning("no space: %s", "full")
    assert caplog.messages == ["no space: full", "no space: full (2 more like this since the last line)"]


def test_the_end_of_a_fault_is_logged_once_and_the_next_fault_at_once(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    log = OccasionalLog(logging.getLogger("test"), clock=lambda: 0.0)
    log.is_over("space again")
    log.warning("no space")
    log.is_over("space again")
    log.is_over("space again")
    log.warning("no space")
    assert caplog.messages == ["no space", "space again", "no space"]
