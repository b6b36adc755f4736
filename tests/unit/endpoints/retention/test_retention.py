"""Retention of each kind of data with a clock that the test moves."""

import asyncio
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from endpoints.audit.event import AuditEvent, AuditQuery
from endpoints.audit.file_log import AUDIT, FileAuditLog
from endpoints.cli.up import RETENTION_SIZES, RETENTIONS
from endpoints.retention import service
from endpoints.retention.kinds import DAY, DEFAULT_DAYS, KINDS, SIZED, Kept
from endpoints.retention.service import GIGABYTE, Retention
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from ppaas.people.settings import PeopleSettings
from ppaas.tasks.records import Task
from storage.memory.store import MemoryStore
from storage.people import HOUR, MapPeople, PeopleCount
from storage.recordings import RecordingsFolder
from storage.records import MapTask
from storage.webhooks.records import Webhook, WebhookDelivery
from tests.support.storage.records import plan
from tests.support.waiting import until

BEGIN = 400_000 * float(HOUR)


class Cloud:
    """Data of each kind, one of each day from ``BEGIN`` to three days later, kept for two days and a minute."""

    def __init__(self, folder: Path) -> None:
        self.clock = ManualClock(BEGIN)
        self.store = MemoryStore()
        self.audit = FileAuditLog(folder / AUDIT)
        self.recordings = RecordingsFolder(folder / "recordings")
        kept = Kept(self.store, self.audit, self.recordings)
        self.retention = Retention(kept, self.audit, dict.fromkeys(KINDS, 2.0 + 60.0 / DAY), self.clock)
        self.store.put_webhook(Webhook(user="ann", id="wh", url="https://a.b", events=("*",)))
        self.store.put_people_settings(MapPeople("ann", "house", PeopleSettings(history=True)))
        for day in range(4):
            self._add(f"day{day}", BEGIN + day * DAY, day)

    def _add(self, name: str, time: float, day: int) -> None:
        self.store.add_plan(plan(name, created=time))
        places = ((1.0, 2.0, 0.0),)
        self.store.put_task(
            MapTask("ann", "house", Task(id=name, kind="go_to", places=places, state="done", ended=time))
        )
        self.store.put_task(MapTask("ann", "house", Task(id=f"open{day}", kind="go_to", places=places, created=time)))
        self.store.add_people_counts([PeopleCount("ann", "house", int(time), zone, 3) for zone in ("", "door")])
        given = {"user": "ann", "hook": "wh", "event": "e", "body": b"{}", "created": BEGIN}
        self.store.put_delivery(WebhookDelivery(id=name, state="dead", ended=time, **given))  # type: ignore[arg-type]
        self.store.put_delivery(WebhookDelivery(id=f"waits{day}", **given))  # type: ignore[arg-type]
        self.audit.record(AuditEvent(action=name, time=time))
        for path in (f"20261126T22414{day}Z.mcap", f"20261126T22414{day}Z-1.partial", f"ring/{day}.mcap"):
            file = self.recordings.of_robot("ann", "tb1") / path
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(b"x")
            os.utime(file, (time, time))

    def left(self) -> dict[str, list[str]]:
        """Return what is left of each kind."""
        store = self.store
        return {
            "plans": sorted(one.id for one in store.plans("house")),
            "tasks": [one.task.id for one in store.tasks("ann", "house")],
            "people": [f"{one.hour - int(BEGIN)}{one.zone}" for one in store.people_counts("ann", "house")],
            "webhooks": [one.id for one in store.deliveries("ann", "wh")],
            "audit": [event.action for event in reversed(self.audit.read(AuditQuery()))],
            "recordings": sorted(one.name for one in self.recordings.path.rglob("*.*")),
        }


@pytest.fixture
def cloud(tmp_path: Path) -> Cloud:
    return Cloud(tmp_path)


REMOVED = {
    "plans": ["day0"],
    "tasks": ["day0"],
    "people": ["0", "0door"],
    "webhooks": ["day0"],
    "audit": ["day0"],
    "recordings": ["0.mcap", "20261126T224140Z-1.partial", "20261126T224140Z.mcap"],
}
"""What has expired three days after the begin: what is of the first day."""


async def test_nothing_expires_before_its_time(cloud: Cloud) -> None:
    before = cloud.left()
    cloud.clock.advance(2 * DAY + 59.0)
    assert [found.expired for found in await cloud.retention.expire(False)] == [0] * len(KINDS)
    assert cloud.left() == before


@pytest.mark.parametrize("kind", KINDS)
async def test_what_has_expired_is_removed_and_recorded(cloud: Cloud, kind: str) -> None:
    before = cloud.left()
    cloud.clock.advance(3 * DAY)
    [found] = [one for one in await cloud.retention.expire(False) if one.kind == kind]
    assert (found.expired, found.fault) == (len(REMOVED[kind]), "")
    left = [one for one in cloud.left()[kind] if one != "expire_data"]
    assert left == [one for one in before[kind] if one not in REMOVED[kind]]
    [event] = [one for one in cloud.audit.read(AuditQuery(action="expire_data")) if one.object == f"retention/{kind}"]
    assert event.details["removed"] == len(REMOVED[kind])
    [view] = [one for one in await cloud.retention.views() if one.kind == kind]
    assert (view.last_run, view.removed) == (cloud.clock(), len(REMOVED[kind]))


async def test_a_dry_run_counts_the_same_and_removes_nothing(cloud: Cloud) -> None:
    before = cloud.left()
    cloud.clock.advance(3 * DAY)
    counted = await cloud.retention.expire(True)
    assert cloud.left() == before
    assert counted == await cloud.retention.expire(False)
    assert [found.expired for found in await cloud.retention.expire(False)] == [0] * len(KINDS)


async def test_everything_expires_in_the_end_but_what_is_open(cloud: Cloud) -> None:
    cloud.clock.advance(30 * DAY)
    await cloud.retention.expire(False)
    left = cloud.left()
    assert left["plans"] == left["people"] == left["recordings"] == []
    assert left["tasks"] == [f"open{day}" for day in range(4)]
    assert left["webhooks"] == [f"waits{day}" for day in range(4)]
    assert set(left["audit"]) == {"expire_data"}


async def test_a_kind_that_fails_keeps_no_other_from_expiring(cloud: Cloud, monkeypatch: pytest.MonkeyPatch) -> None:
    def away(*_: object, **__: object) -> list[str]:
        raise Unavailable("the store is away")

    monkeypatch.setattr(cloud.store, "plan_maps", away)
    cloud.clock.advance(3 * DAY)
    found = {one.kind: one for one in await cloud.retention.expire(False)}
    assert (found["plans"].expired, found["plans"].fault) == (0, "the store is away")
    assert found["tasks"].expired == 1
    [event] = cloud.audit.read(AuditQuery(outcome="failed"))
    assert event.object == "retention/plans"
    [view] = [one for one in await cloud.retention.views() if one.kind == "plans"]
    assert (view.last_run, view.removed) == (cloud.clock(), None)


async def test_the_job_runs_every_day(cloud: Cloud, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service, "DELAY", 0.0)
    monkeypatch.setattr(service, "DAY", 0.01)
    asked: list[bool] = []
    real: Callable[[bool], object] = cloud.retention.expire

    async def counted(dry_run: bool) -> object:
        asked.append(dry_run)
        return await real(dry_run)  # type: ignore[misc]

    monkeypatch.setattr(cloud.retention, "expire", counted)
    job = asyncio.create_task(cloud.retention.run())
    await until(lambda: len(asked) > 2)
    job.cancel()
    await asyncio.gather(job, return_exceptions=True)
    assert set(asked) == {False}


async def test_without_settings_only_kinds_with_a_default_expire(cloud: Cloud) -> None:
    plain = Retention(Kept(cloud.store, cloud.audit, None), cloud.audit, {}, cloud.clock)
    cloud.clock.advance(365 * DAY)
    assert [found.kind for found in await plain.expire(True)] == [*DEFAULT_DAYS]
    assert plain.seconds("tasks") == 7 * DAY and plain.seconds("plans") == float("inf")


def test_the_command_line_names_all_kinds() -> None:
    assert (*KINDS,) == RETENTIONS
    assert SIZED == RETENTION_SIZES


@pytest.mark.parametrize(("days", "removed"), [({}, 7), ({"recordings": 2.5}, 7), ({"recordings": 0.5}, 12)])
async def test_the_oldest_recordings_beyond_a_size_are_removed(
    cloud: Cloud, days: dict[str, float], removed: int
) -> None:
    """Twelve files of a byte, of which five may stay: the last of the second day, and those of the last days."""
    sized = Retention(
        Kept(cloud.store, cloud.audit, cloud.recordings), cloud.audit, days, cloud.clock,
        gigabytes={"recordings": 5 / GIGABYTE},
    )  # fmt: skip
    before = cloud.left()["recordings"]
    cloud.clock.advance(4 * DAY)
    [counted] = [one for one in await sized.expire(True) if one.kind == "recordings"]
    assert cloud.left()["recordings"] == before
    [found] = [one for one in await sized.expire(False) if one.kind == "recordings"]
    assert (found, found.expired, found.before) == (counted, removed, 0.0 if not days else found.before)
    left = cloud.left()["recordings"]
    assert len(left) == len(before) - removed and not [name for name in left if name.startswith(("0.", "1."))]
    [event] = cloud.audit.read(AuditQuery(action="expire_data"))
    assert event.details == {**({"days": days["recordings"]} if days else {}), "gigabytes": 5e-9, "removed": removed}
    views = {one.kind: one.gigabytes for one in await sized.views()}
    assert {kind for kind, limit in views.items() if limit} == {"recordings"}


async def test_a_recording_in_progress_stays_however_large_it_is(cloud: Cloud) -> None:
    kept = Kept(cloud.store, cloud.audit, cloud.recordings)
    sized = Retention(kept, cloud.audit, {}, cloud.clock, gigabytes={"recordings": 1 / GIGABYTE})
    cloud.clock.advance(3 * DAY + 30.0)
    await sized.expire(False)
    assert cloud.left()["recordings"] == ["20261126T224143Z-1.partial", "20261126T224143Z.mcap", "3.mcap"]


async def test_another_retention_holds_from_the_next_removal_on(cloud: Cloud) -> None:
    cloud.clock.advance(3 * DAY)
    cloud.retention.change({"plans": 2.0 + 60.0 / DAY}, {"recordings": 7.0})
    assert cloud.retention.seconds("plans") == 2 * DAY + 60.0
    assert cloud.retention.seconds("tasks") == DEFAULT_DAYS["tasks"] * DAY
    removed = {found.kind: found.expired for found in await cloud.retention.expire(False)}
    assert removed == {kind: 1 if kind == "plans" else 0 for kind in removed} and "plans" in removed
    assert "audit" not in removed, "what has no days is kept"
    assert [one.gigabytes for one in await cloud.retention.views() if one.kind == "recordings"] == [7.0]
