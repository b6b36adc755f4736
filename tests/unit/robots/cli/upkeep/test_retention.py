"""Command ``ppaas retention``: what is kept, what has expired, and its removal."""

import json

import pytest

from endpoints.audit.event import MemoryAuditLog
from endpoints.retention.calls import ExpiredData
from endpoints.retention.kinds import Kept
from endpoints.retention.service import Retention
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import plan


async def test_the_command_shows_counts_and_removes(ppaas: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = Kept(ppaas.services.store, MemoryAuditLog(), None)
    retention = Retention(kept, ppaas.services.audit, {"plans": 1.0})
    object.__setattr__(ppaas.services, "retention", retention)
    ppaas.services.store.add_plan(plan("old", created=1.0))
    shown = await ppaas("retention", "show", user="admin")
    assert [row[:2] for row in shown.rows if row[0] == "plans"] == [["plans", "1"]]
    counted = json.loads((await ppaas("retention", "run", "--dry-run", "--json", user="admin")).out)
    assert [one["expired"] for one in counted if one["kind"] == "plans"] == [1]
    assert (await ppaas("retention", "run", user="admin")).status == 0
    assert ppaas.services.store.plans("house") == []

    async def failed(_dry_run: bool) -> list[ExpiredData]:
        return [ExpiredData("plans", 1.0, fault="the store is away")]

    monkeypatch.setattr(retention, "expire", failed)
    failing = await ppaas("retention", "run", user="admin")
    assert (failing.status, "the store is away" in failing.out, "could be removed" in failing.err) == (1, True, True)
