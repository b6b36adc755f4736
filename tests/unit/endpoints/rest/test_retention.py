"""Retention over REST, for administrators."""

import dataclasses

import httpx
import pytest

from endpoints.audit.event import MemoryAuditLog
from endpoints.resources.services import Services
from endpoints.retention.kinds import Kept
from endpoints.retention.service import Retention
from ppaas.clock import ManualClock
from tests.support.storage.records import plan
from tests.unit.endpoints.conftest import LogIn

PATH = "/v1/retention"
NOW = 1_000_000.0


def kept_by(services: Services) -> Retention:
    """Return a retention of plans for a day over the store of the services."""
    kept = Kept(services.store, MemoryAuditLog(), None)
    return Retention(kept, services.audit, {"plans": 1.0}, ManualClock(NOW))


@pytest.fixture
def services(services: Services) -> Services:
    return dataclasses.replace(services, retention=kept_by(services))


async def test_administrators_see_what_is_kept_and_remove_what_has_expired(
    client: httpx.AsyncClient, log_in: LogIn, services: Services
) -> None:
    admin = await log_in("admin")
    services.store.add_plans([plan("old", created=1.0), plan("new", created=NOW)])
    shown = {one["kind"]: one for one in (await client.get(PATH, headers=admin)).json()}
    assert (shown["plans"]["days"], shown["tasks"]["days"], shown["audit"]["days"]) == (1.0, 7.0, None)
    counted = (await client.post(PATH, headers=admin, json={"dry_run": True})).json()
    assert {"kind": "plans", "before": NOW - 86400.0, "expired": 1, "fault": ""} in counted
    assert services.store.plan("old").id == "old"
    assert {one["expired"] for one in (await client.post(PATH, headers=admin, json={})).json()} == {0, 1}
    assert [one.id for one in services.store.plans("house")] == ["new"]
    shown = {one["kind"]: one for one in (await client.get(PATH, headers=admin)).json()}
    assert (shown["plans"]["last_run"], shown["plans"]["removed"]) == (NOW, 1)


async def test_others_see_and_remove_nothing(client: httpx.AsyncClient, log_in: LogIn) -> None:
    ann = await log_in("ann")
    assert (await client.get(PATH, headers=ann)).status_code == 403
    assert (await client.post(PATH, headers=ann, json={})).status_code == 403
