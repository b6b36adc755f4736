"""Warnings about clients: few a second for one address, one line each."""

import logging

import pytest

from endpoints.http.refusal_log import MAX_ADDRESSES, PER_SECOND, RefusalLog
from ppaas.clock import ManualClock


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock(5.0)


@pytest.fixture
def log(clock: ManualClock, caplog: pytest.LogCaptureFixture) -> RefusalLog:
    caplog.set_level(logging.DEBUG)
    return RefusalLog(logging.getLogger("refusals"), clock)


def test_a_refusal_is_one_warning_with_its_address(log: RefusalLog, caplog: pytest.LogCaptureFixture) -> None:
    log.add("203.0.113.7", "robot ann/tb1: conflict: connected already")
    [record] = caplog.records
    assert (record.levelname, record.getMessage()) == (
        "WARNING", "203.0.113.7: robot ann/tb1: conflict: connected already",
    )  # fmt: skip


def test_refusals_of_one_address_are_limited_and_the_rest_is_counted(
    log: RefusalLog, clock: ManualClock, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(100):
        log.add("203.0.113.7", "no")
    log.add("203.0.113.8", "no")
    assert len(caplog.records) == PER_SECOND + 1
    caplog.clear()
    clock.advance(1.0)
    log.add("203.0.113.7", "no")
    assert [record.getMessage() for record in caplog.records] == [
        f"203.0.113.7: {100 - PER_SECOND} more warnings like these were not logged", "203.0.113.7: no",
    ]  # fmt: skip


def test_text_of_a_client_cannot_forge_a_line(log: RefusalLog, caplog: pytest.LogCaptureFixture) -> None:
    log.add("203.0.113.7", "unknown robot 'x\nERROR all is lost\x1b[0m'" + "y" * 10_000)
    [message] = [record.getMessage() for record in caplog.records]
    assert "\n" not in message and "\x1b" not in message and len(message) < 600


def test_the_memory_of_addresses_is_limited(log: RefusalLog) -> None:
    for number in range(2 * MAX_ADDRESSES):
        log.add(f"2001:db8::{number:x}", "no")
    assert len(log._seen) == MAX_ADDRESSES
