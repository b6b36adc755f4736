"""An endpoint of another host records events in the audit log of the cloud, also those of a time without a master."""

import asyncio
from collections.abc import AsyncIterator

import pytest

from endpoints.audit import data_folder
from endpoints.audit.data_folder import DataFolder, FarAuditLog
from endpoints.audit.event import AuditEvent, AuditQuery, MemoryAuditLog
from ppaas.errors import Unavailable
from tests.support.waiting import until


class Reached(DataFolder):
    """Data folder of a master that may be away."""

    def __init__(self, log: MemoryAuditLog) -> None:
        super().__init__(log, None)
        self.away = False

    async def record_events(self, events: list[AuditEvent]) -> None:
        if self.away:
            raise Unavailable("no master was reachable")
        await super().record_events(events)


@pytest.fixture
def cloud() -> MemoryAuditLog:
    return MemoryAuditLog()


@pytest.fixture
def folder(cloud: MemoryAuditLog) -> Reached:
    return Reached(cloud)


@pytest.fixture
async def log(folder: Reached, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[FarAuditLog]:
    monkeypatch.setattr(data_folder, "PERIOD", 0.01)
    made = FarAuditLog(folder)
    yield made
    await made.close()


def actions(log: MemoryAuditLog) -> list[str]:
    """Return the actions of all events, oldest first."""
    return [event.action for event in reversed(log.read(AuditQuery(), limit=100))]


async def test_events_reach_the_log_of_the_cloud_in_order(log: FarAuditLog, cloud: MemoryAuditLog) -> None:
    for action in ("connect", "put_robot", "disconnect"):
        log.record(AuditEvent(action=action))
    await until(lambda: actions(cloud) == ["connect", "put_robot", "disconnect"])
    found = await asyncio.to_thread(log.read, AuditQuery(action="put_robot"))
    assert [event.action for event in found] == ["put_robot"]


async def test_events_wait_for_a_master_and_the_fault_is_reported(
    log: FarAuditLog, folder: Reached, cloud: MemoryAuditLog
) -> None:
    folder.away = True
    log.record(AuditEvent(action="connect"))
    await until(lambda: log.fault is not None)
    assert log.fault is not None and "wait for the master" in log.fault
    folder.away = False
    await until(lambda: actions(cloud) == ["connect"])
    await until(lambda: log.fault is None)


async def test_events_beyond_the_limit_are_counted(
    log: FarAuditLog, folder: Reached, cloud: MemoryAuditLog, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(data_folder, "MAX_WAITING", 3)
    folder.away = True
    for number in range(5):
        log.record(AuditEvent(action=f"a{number}"))
    folder.away = False
    await until(lambda: "lose_events" in actions(cloud))
    [lost] = cloud.read(AuditQuery(action="lose_events"))
    assert lost.details == {"events": 2}


async def test_a_reader_learns_that_the_master_is_away(log: FarAuditLog, monkeypatch: pytest.MonkeyPatch) -> None:
    async def never(*_: object) -> list[AuditEvent]:
        await asyncio.sleep(10.0)
        return []

    monkeypatch.setattr(log._folder, "read_events", never)
    monkeypatch.setattr(data_folder, "READ_TIMEOUT", 0.05)
    with pytest.raises(Unavailable, match="does not answer"):
        await asyncio.to_thread(log.read, AuditQuery())


async def test_the_last_events_are_sent_at_the_end(folder: Reached, cloud: MemoryAuditLog) -> None:
    log = FarAuditLog(folder)
    log.record(AuditEvent(action="disconnect"))
    await log.close()
    assert actions(cloud) == ["disconnect"]
