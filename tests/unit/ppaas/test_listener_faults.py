"""Faults of listeners, which concern nobody else."""

import logging

import pytest

from ppaas.errors import InvalidInput, PPaaSError
from ppaas.listener_faults import ListenerFaults

logger = logging.getLogger(__name__)


def fail(error: Exception) -> None:
    raise error


def test_a_fault_is_returned_as_an_error_to_report() -> None:
    faults = ListenerFaults(logger)
    refusal = InvalidInput("negative")
    assert faults.call("a", fail, refusal) is refusal
    fault = faults.call("a", fail, KeyError("x"))
    assert isinstance(fault, PPaaSError) and str(fault) == "internal error: KeyError"
    heard: list[int] = []
    assert faults.call("a", heard.append, 1) is None and heard == [1]


def test_each_listener_is_logged_once_for_each_kind_of_exception(caplog: pytest.LogCaptureFixture) -> None:
    faults = ListenerFaults(logger)
    for _ in range(3):
        for name, error in (("a", KeyError("x")), ("a", ValueError("x")), ("b", KeyError("x"))):
            faults.call(name, fail, error)
    logged = [record for record in caplog.records if record.levelno == logging.ERROR]
    assert [record.args for record in logged] == [("a",), ("a",), ("b",)]
    assert all(record.exc_info is not None for record in logged)


def test_a_refusal_is_returned_without_a_line_in_the_log(caplog: pytest.LogCaptureFixture) -> None:
    faults = ListenerFaults(logger)
    refusal = InvalidInput("negative")
    assert faults.deliver("a", fail, refusal) is refusal
    assert caplog.records == []
    fault = faults.deliver("a", fail, KeyError("x"))
    assert str(fault) == "internal error: KeyError" and len(caplog.records) == 1
    assert faults.deliver("a", list[int]().append, 1) is None
