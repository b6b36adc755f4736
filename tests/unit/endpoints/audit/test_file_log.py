"""Audit log that a thread writes.

Faults of the disk: it is full when the log is opened, becomes full while events come, and has space again.
"""

import asyncio
import logging
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from endpoints.audit import file_log
from endpoints.audit.event import AuditEvent, AuditQuery
from endpoints.audit.file_log import (
    AUDIT,
    MAX_WINDOWS,
    OF_STRANGERS,
    PER_KEY,
    WINDOW,
    FileAuditLog,
    FloodGuard,
    cloud_audit,
    record_on_host,
)
from endpoints.audit.files import AuditFiles
from ppaas.clock import ManualClock
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


def refused(user: str | None = "ann", token: str | None = "0123456789ab", **fields: object) -> AuditEvent:
    return AuditEvent(action="remove_map", outcome="refused", user=user, token=token, address="10.0.0.1", **fields)  # type: ignore[arg-type]


def admitted(guard: FloodGuard, events: list[AuditEvent]) -> int:
    return sum(len(guard.admit(event)) for event in events)


# Folding of similar events.
#
# Who may flood: a stranger with logins or tokens that are wrong, from one address or many; a user with actions that
# are refused; a user who repeats an action on one object.


def test_similar_events_beyond_a_number_are_folded_into_one() -> None:
    clock = ManualClock()
    guard = FloodGuard(clock)
    assert admitted(guard, [refused(object=f"maps/{n}") for n in range(PER_KEY + 5)]) == PER_KEY
    clock.advance(WINDOW)
    [folded] = guard.ended()
    assert (folded.repeats, folded.object) == (5, f"maps/{PER_KEY + 4}")
    assert admitted(guard, [refused()]) == 1


def test_actions_that_were_performed_on_different_objects_are_all_kept() -> None:
    guard = FloodGuard(ManualClock())
    done = [AuditEvent(action="put_robot", user="ann", token="0", object=f"robots/{n}") for n in range(100)]
    assert admitted(guard, done) == 100


def test_another_user_and_another_action_are_not_folded_with_these() -> None:
    guard = FloodGuard(ManualClock())
    admitted(guard, [refused()] * 100)
    assert admitted(guard, [refused("bob"), AuditEvent(action="put_robot", user="ann", token="0")]) == 2


def test_strangers_at_many_addresses_are_folded_together() -> None:
    guard = FloodGuard(ManualClock())
    logins = [
        AuditEvent(action="log_in", outcome="refused", user=f"u{n}", address=f"10.0.{n % 100}.1") for n in range(1000)
    ]
    assert admitted(guard, logins) == OF_STRANGERS


def test_strangers_at_one_address_are_folded_whatever_names_they_give() -> None:
    guard = FloodGuard(ManualClock())
    logins = [AuditEvent(action="log_in", outcome="refused", user=f"u{n}", address="10.0.0.1") for n in range(100)]
    assert admitted(guard, logins) == PER_KEY


def test_the_memory_of_the_guard_is_bounded() -> None:
    guard = FloodGuard(ManualClock())
    for number in range(MAX_WINDOWS + 100):
        guard.admit(AuditEvent(action="put_robot", user="ann", token="0", object=f"robots/{number}"))
    assert len(guard._windows) == MAX_WINDOWS


def actions(data: Path) -> list[str]:
    return [event.action for event in AuditFiles(data / AUDIT).read(AuditQuery())][::-1]


# The audit log of a data folder: of a cloud, and of commands beside it.


async def test_start_and_stop_of_a_cloud_are_recorded(tmp_path: Path) -> None:
    async with cloud_audit(tmp_path) as log:
        log.record(AuditEvent(action="put_robot", user="ann"))
    assert actions(tmp_path) == ["start_cloud", "put_robot", "stop_cloud"]


async def test_the_start_and_stop_of_an_endpoint_are_not_those_of_the_cloud(tmp_path: Path) -> None:
    async with cloud_audit(tmp_path) as of_cloud, cloud_audit(tmp_path, is_cloud=False) as log:
        await asyncio.to_thread(of_cloud.read, AuditQuery())  # the start is written in a thread of its own
        log.record(AuditEvent(action="put_robot", user="ann"))
    assert actions(tmp_path) == ["start_cloud", "put_robot", "stop_cloud"]


async def test_a_command_on_the_host_is_recorded_while_the_cloud_runs(tmp_path: Path) -> None:
    async with cloud_audit(tmp_path) as log:
        await asyncio.to_thread(log.read, AuditQuery())
        await asyncio.to_thread(record_on_host, tmp_path, AuditEvent(action="make_ticket", object="machines/m2"))
    assert actions(tmp_path) == ["start_cloud", "make_ticket", "stop_cloud"]
    [event] = AuditFiles(tmp_path / AUDIT).read(AuditQuery(action="make_ticket"))
    assert str(event.user).endswith("(host)")


def test_a_command_goes_on_if_its_event_cannot_be_stored(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    record_on_host(tmp_path / "nowhere", AuditEvent(action="make_ticket"))
    assert "cannot be written" in caplog.text


WRITERS, BATCHES, BATCH = 3, 60, 3

PROGRAM = """
import sys
from pathlib import Path
from endpoints.audit.event import AuditEvent
from endpoints.audit.files import AuditFiles

path, writer, batches, batch = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
files = AuditFiles(path, max_size=4000, files=60)
print("ready", flush=True)
sys.stdin.readline()
for number in range(batches):
    files.append([AuditEvent(action="put_robot", user=writer, object=f"{number}/{at}") for at in range(batch)])
"""


def start(path: Path, writer: int) -> subprocess.Popen[str]:
    arguments = [str(path), str(writer), str(BATCHES), str(BATCH)]
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )


# Several processes append to the audit log of one data folder, while its files are rotated and read.


def test_no_event_of_several_processes_is_lost_repeated_or_out_of_order(tmp_path: Path) -> None:
    path = tmp_path / "audit.jsonl"
    writers = [start(path, number) for number in range(WRITERS)]
    for writer in writers:
        assert writer.stdout is not None and writer.stdout.readline() == "ready\n"
    for writer in writers:
        assert writer.stdin is not None
        writer.stdin.write("go\n")
        writer.stdin.flush()
    files = AuditFiles(path, max_size=4000, files=60)
    while any(writer.poll() is None for writer in writers):
        assert in_order(files.read(AuditQuery(), limit=10_000)), "a reader sees no gap"
    for writer in writers:
        writer.communicate(timeout=30)
        assert writer.returncode == 0
    found = files.read(AuditQuery(), limit=10_000)
    assert len(found) == WRITERS * BATCHES * BATCH
    assert in_order(found)
    for user in map(str, range(WRITERS)):
        own = [event.object for event in reversed(found) if event.user == user]
        assert own == [f"{number}/{at}" for number in range(BATCHES) for at in range(BATCH)]
    assert len(list(tmp_path.iterdir())) > 5, "files were rotated"


def in_order(events: list[AuditEvent]) -> bool:
    """Return whether the numbers of events, newest first, end with 1 and have no gap."""
    return [event.number for event in events] == list(range(len(events), 0, -1))
