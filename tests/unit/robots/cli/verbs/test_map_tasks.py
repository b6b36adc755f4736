"""Tests of ``ppaas map task``."""

import json
import time

import pytest
from msgspec.structs import replace

from robots.cli.verbs import map_tasks
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map


@pytest.fixture
def office(ppaas: CommandLine) -> CommandLine:
    """Return the command line of ann, who has the map house."""
    put_map(ppaas.services.map_store, house())
    return ppaas


async def test_a_task_is_added_listed_shown_and_cancelled(office: CommandLine) -> None:
    places = ["--at", "1", "2", "--at", "-4", "1.5", "1.57"]
    words = ["pick_drop", *places, "--priority", "2", "--within", "60", "--label", "lift=yes", "--json"]
    added = json.loads((await office("map", "task", "add", "house", *words)).out)
    assert added["places"] == [[1.0, 2.0, 0.0], [-4.0, 1.5, 1.57]]
    assert (added["priority"], added["labels"]) == (2, {"lift": "yes"})
    assert 0.0 < added["deadline"] - time.time() <= 60.0
    assert (await office("map", "task", "list", "house")).rows[1][:4] == [added["id"], "pick_drop", "2", "queued"]
    assert (await office("map", "task", "show", "house", added["id"])).rows[1][0] == added["id"]
    assert (await office("map", "task", "cancel", "house", added["id"])).status == 0
    assert "no such tasks" in (await office("map", "task", "list", "house", "--state", "open")).out
    again = await office("map", "task", "cancel", "house", added["id"])
    assert (again.status, "cancelled" in again.err) == (1, True)


@pytest.mark.parametrize(("state", "status"), [("done", 0), ("failed", 1)])
async def test_a_command_waits_for_the_end_of_a_task(
    office: CommandLine, monkeypatch: pytest.MonkeyPatch, state: str, status: int
) -> None:
    monkeypatch.setattr(map_tasks, "POLL", 0.01)

    async def end(user: str, map_id: str) -> None:
        [kept] = office.services.store.tasks(user, map_id)
        ended = replace(kept.task, state=state, reason="" if state == "done" else "stuck")
        office.services.store.put_task(replace(kept, task=ended))

    monkeypatch.setattr(office.cloud.tasks, "changed", end)
    ended = await office("map", "task", "add", "house", "go_to", "--at", "1", "2", "--wait")
    assert ended.status == status
    assert ("stuck" in ended.err) == (state == "failed")


async def test_what_is_wrong_is_said(office: CommandLine) -> None:
    assert "NAME=VALUE" in (await office("map", "task", "add", "house", "go_to", "--at", "1", "2", "--label", "x")).err
    assert "2 places" in (await office("map", "task", "add", "house", "pick_drop", "--at", "1", "2")).err
