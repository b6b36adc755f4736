"""Verbs of ``ppaas map``: reviews, tasks and traffic."""

import io
import json
import time
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from PIL import Image
from rich.console import Console

from robots.cli.verbs import map_tasks
from robots.cli.verbs.map_traffic import render
from robots.client.rest import RestClient
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.traffic import add_traffic
from tests.support.storage.records import house, pgm, put_map


@pytest.fixture
async def proposed(ppaas: CommandLine, house: Path) -> int:
    """Return the number of a version that waits."""
    await ppaas("map", "publish", str(house))
    house.with_suffix(".pgm").write_bytes(pgm(value=0))
    answer = await ppaas("map", "publish", str(house), "--review", "--message", "a wall", "--json")
    return int(json.loads(answer.out)["number"])


async def test_a_proposed_version_is_listed_drawn_and_approved(
    ppaas: CommandLine, proposed: int, tmp_path: Path
) -> None:
    listed = await ppaas("map", "reviews", "house")
    assert listed.rows[1][0] == str(proposed)
    assert "a wall" in listed.out
    shown = await ppaas("map", "reviews", "house", str(proposed), "--plot", str(tmp_path / "change.png"))
    assert "4×3 at (0, 0)" in shown.out
    assert Image.open(tmp_path / "change.png").size == (4, 3)
    approved = json.loads((await ppaas("map", "approve", "house", "--why", "seen it", "--json")).out)
    assert approved["message"] == "a wall"
    assert (await ppaas("map", "reviews", "house", str(proposed))).out.count("seen it") == 1


async def test_a_proposed_version_is_refused_with_a_reason(ppaas: CommandLine, proposed: int) -> None:
    assert (await ppaas("map", "refuse", "house", str(proposed))).status == 2
    refused = await ppaas("map", "refuse", "house", str(proposed), "--why", "a person", "--json")
    assert json.loads(refused.out)["state"] == "refused"
    failed = await ppaas("map", "approve", "house")
    assert failed.status == 1
    assert "those that wait: none" in failed.err


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


async def test_options_of_a_task_are_those_of_rest(office: CommandLine) -> None:
    first = json.loads((await office("map", "task", "add", "house", "go_to", "--at", "1", "2", "--json")).out)
    places = ["--at", "1", "2", "--at", "3", "4", "--hold", "1", "--hold", "1=30", "--hold", "2=5"]
    words = [*places, "--weight", "12.5", "--start", "2100-01-01T08:00+00:00", "--after", f"{first['id']}=ended"]
    repeat = ["--repeat-at", "08:30", "--days", "mon", "--zone", "Europe/Berlin", "--times", "3", "--preempt", "--json"]
    added = json.loads((await office("map", "task", "add", "house", "pick_drop", *words, *repeat)).out)
    assert added["holds"] == [
        {"confirm": True, "seconds": 30.0},
        {"seconds": 5.0},
    ]
    assert (added["weight"], added["preempts"], added["run"]) == (12.5, True, 1)
    assert added["after"] == [{"task": first["id"], "on": "ended"}]
    assert added["not_before"] == 4102731000.0  # the first Monday of 2100, 08:30 in Berlin
    assert (added["repeat"]["days"], added["repeat"]["count"]) == (["mon"], 3)
    unknown = await office("map", "task", "add", "house", "go_to", "--at", "1", "2", "--robot", "tb9")
    assert (unknown.status, "tb9" in unknown.err) == (1, True)


async def test_a_task_is_confirmed(office: CommandLine) -> None:
    words = ["go_to", "--at", "1", "2", "--hold", "1", "--json"]
    name = json.loads((await office("map", "task", "add", "house", *words)).out)["id"]
    early = await office("map", "task", "confirm", "house", name)
    assert (early.status, "does not wait" in early.err) == (1, True)
    kept = office.services.store.task("ann", "house", name)
    holds = replace(kept.task, state="active", robot="tb1", holding=5.0)
    office.services.store.put_task(replace(kept, task=holds))
    assert (await office("map", "task", "confirm", "house", name)).status == 0
    assert office.services.store.task("ann", "house", name).task.confirmed == 0


@pytest.mark.parametrize(
    ("words", "advice"),
    [
        (["--hold", "x"], "NUMBER"),
        (["--hold", "2"], "places 1 to 1"),
        (["--start", "soon"], "2026-12-01T08:30"),
        (["--after", "t=never"], "done, failed, ended"),
        (["--times", "3"], "--repeat-at"),
        (["--repeat-at", "8:30"], "at"),
        (["--repeat-every", "60", "--zone", "Mars/Base"], "time zone"),
    ],
)
async def test_options_that_are_malformed_are_refused(office: CommandLine, words: list[str], advice: str) -> None:
    refused = await office("map", "task", "add", "house", "go_to", "--at", "1", "2", *words)
    assert (refused.status, advice in refused.err) == (1, True), refused.err


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


@pytest.fixture
def busy(ppaas: CommandLine) -> CommandLine:
    """Return the command line of ann, who has two robots in the traffic of the map house."""
    put_map(ppaas.services.map_store, house())
    add_traffic(ppaas.cloud, "ann", "house")
    return ppaas


async def test_robots_are_listed_with_state_goal_waits_and_cells(busy: CommandLine) -> None:
    ended = await busy("map", "traffic", "house")
    assert (ended.status, ended.err) == (0, "")
    assert "house  2 robots  1 waiting  12 goals reached" in ended.out.splitlines()[0]
    rows = [row for row in ended.rows if row]
    assert ["tb1", "waiting", "tb2", "3s", "4.00,", "2.00", "1.00", "2.00", "2"] in rows
    assert ["tb2", "idle", "-", "-", "-", "2.00", "2.00", "1"] in rows
    whole = json.loads((await busy("map", "traffic", "house", "--json")).out)
    assert whole["robots"][0]["way"] == [[1.0, 2.0], [1.5, 2.0]]


async def test_a_map_without_traffic_says_why(ppaas: CommandLine) -> None:
    put_map(ppaas.services.map_store, house())
    ended = await ppaas("map", "traffic", "house")
    assert (ended.status, ended.out) == (1, "")
    assert "no robot of user 'ann' takes part in the traffic of map 'house' now" in ended.err


async def test_traffic_is_watched_until_interrupted(busy: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    get, calls = RestClient.get, iter(range(2))

    async def interrupted(client: RestClient, path: str) -> Any:
        if next(calls, None) is None:
            raise KeyboardInterrupt
        return await get(client, path)

    monkeypatch.setattr(RestClient, "get", interrupted)
    ended = await busy("map", "traffic", "house", "--watch", "--json", "--interval", "0.1")
    assert ended.status == 130
    assert [json.loads(line)["goals"] for line in ended.out.splitlines()] == [12, 12]


async def test_the_live_view_draws_the_robots(busy: CommandLine) -> None:
    seen = json.loads((await busy("map", "traffic", "house", "--json")).out)
    console = Console(width=120, file=io.StringIO(), record=True)
    console.print(render(seen))
    text = console.export_text()
    assert "1 waiting" in text and "4.00, 2.00" in text


async def test_robots_are_taken_out_and_put_back(busy: CommandLine) -> None:
    ended = await busy("map", "traffic", "house", "--take-out", "tb1")
    assert (ended.status, ended.err) == (0, "")
    assert "tb1" in ended.out
    assert busy.cloud.taken_out == {("ann", "house", "tb1")}
    assert (await busy("map", "traffic", "house", "--put-back", "tb1")).status == 0
    assert busy.cloud.taken_out == set()
    unknown = await busy("map", "traffic", "house", "--take-out", "tb9")
    assert unknown.status == 1 and "tb1, tb2" in unknown.err
    assert (await busy("map", "traffic", "house", "--take-out", "tb1", "--put-back", "tb1")).status == 2
