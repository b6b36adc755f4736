"""Audit log that a thread writes.

Faults of the disk: it is full when the log is opened, becomes full while events come, and has space again.
"""

import logging
import os
from collections.abc import Iterator
from pathlib import Path

import pytest

from endpoints.audit import file_log
from endpoints.audit.event import AuditEvent, AuditQuery
from endpoints.audit.file_log import FileAuditLog
from ppaas.errors import InvalidInput
from tests.support.waiting import wait_until

ALL = AuditQuery()


def event(number: int = 0) -> AuditEvent:
    return AuditEvent(action="put_robot", user="ann", token="0", object=f"robots/{number}")


@pytest.fixture
def log(tmp_path: Path) -> Iterator[FileAuditLog]:
    made = FileAuditLog(tmp_path / "audit.jsonl", period=0.01)
    yield made
    made.close()


def objects(log: FileAuditLog) -> list[str | None]:
    return [found.object for found in log.read(ALL, limit=10_000)]


def test_events_are_stored_in_their_order(log: FileAuditLog) -> None:
    for number in range(3000):
        log.record(event(number))
    assert objects(log) == [f"robots/{number}" for number in reversed(range(3000))]


def test_events_outlive_the_process(tmp_path: Path) -> None:
    first = FileAuditLog(tmp_path / "log")
    first.record(event(1))
    first.close()
    second = FileAuditLog(tmp_path / "log")
    assert objects(second) == ["robots/1"]
    second.close()


def test_an_event_that_was_folded_is_stored_at_the_end(tmp_path: Path) -> None:
    first = FileAuditLog(tmp_path / "log")
    for _ in range(50):
        first.record(event(1))
    first.close()
    second = FileAuditLog(tmp_path / "log")
    assert second.read(ALL)[0].repeats == 30
    second.close()


def test_events_wait_in_memory_while_the_disk_is_full(
    log: FileAuditLog, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(*_arguments: object) -> int:
        raise OSError(28, "No space left on device")

    caplog.set_level(logging.INFO)
    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        for number in range(5):
            log.record(event(number))
        wait_until(lambda: log.fault is not None)
        assert "No space left" in str(log.fault)
    wait_until(lambda: log.fault is None)
    assert objects(log) == [f"robots/{number}" for number in reversed(range(5))]
    assert [record.levelname for record in caplog.records] == ["ERROR", "INFO"]


def test_events_beyond_the_limit_are_dropped_and_counted(log: FileAuditLog, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_arguments: object) -> int:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", full)
        patch.setattr(file_log, "MAX_WAITING", 10)
        log.record(event(0))
        wait_until(lambda: log.fault is not None)
        for number in range(1, 30):
            log.record(event(number))
    wait_until(lambda: log.fault is None)
    wait_until(lambda: log.read(ALL)[0].action == "lose_events")
    assert log.read(ALL)[0].details == {"events": 20}
    assert len(objects(log)) == 11


def test_a_log_that_cannot_be_written_is_an_error_at_the_start(tmp_path: Path) -> None:
    (tmp_path / "log").mkdir()
    with pytest.raises(InvalidInput, match="cannot write the audit log"):
        FileAuditLog(tmp_path / "log")


def test_a_link_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "log").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InvalidInput, match="cannot write the audit log"):
        FileAuditLog(tmp_path / "log")
    assert not (tmp_path / "elsewhere").exists()
