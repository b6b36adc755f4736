"""``ppaas map traffic``: what robots hold and wait for, and robots that are taken out and put back."""

import io
import json
from typing import Any

import pytest
from rich.console import Console

from robots.cli.verbs.map_traffic import render
from robots.client.rest import RestClient
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.traffic import add_traffic
from tests.support.storage.records import house, put_map


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
