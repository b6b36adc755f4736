"""The audit log of a data folder: of a cloud, and of commands beside it."""

import asyncio
from pathlib import Path

import pytest

from endpoints.audit.cloud_audit import AUDIT, cloud_audit, record_on_host
from endpoints.audit.event import AuditEvent, AuditQuery
from endpoints.audit.files import AuditFiles


def actions(data: Path) -> list[str]:
    return [event.action for event in AuditFiles(data / AUDIT).read(AuditQuery())][::-1]


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
