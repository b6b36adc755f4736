"""``ppaas people``: people on a map, whom robots follow, and counts."""

import io
import json
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from ppaas.people.settings import CountingZone, PeopleSettings
from robots.cli.commands.people import render
from robots.client.rest import RestClient
from storage.people import HOUR, MapPeople, PeopleCount
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.people import add_group, person
from tests.support.storage.records import house, put_map

DOOR = CountingZone("door", [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
RECENT = 500_000 * HOUR


@pytest.fixture
def watched(ppaas: CommandLine) -> CommandLine:
    """Return the command line of ann, whose robots see two people in the map house."""
    put_map(ppaas.services.map_store, house())
    add_group(ppaas.cloud, "ann", "house", person(1, name="Zoë"), person(2, x=4.0, state="predicted", group=3))
    return ppaas


def settings(ppaas: CommandLine) -> PeopleSettings:
    return ppaas.services.store.map_people("ann", "house").settings


async def test_people_are_listed_with_who_follows_them_and_why(watched: CommandLine) -> None:
    ended = await watched("people", "house")
    assert (ended.status, ended.err) == (0, "")
    assert "house  2 people  1 followed (rule nearest)" in ended.out.splitlines()[0]
    rows = [row for row in ended.rows if row]
    assert ["1", "Zoë", "seen", "1.00", "2.00", "0.5", "0s", "-", "tb1/4", "tb1", "nearest"] in rows
    assert ["2", "-", "predicted", "4.00", "2.00", "0.5", "0s", "3", "tb1/4", "-", "-"] in rows
    assert ["tb1", "0.00", "2.00", "0.20", "2", "1", "yes", "-"] in rows
    assert ["tb2", "-", "-", "-", "0", "-", "yes", "-"] in rows
    whole = json.loads((await watched("people", "house", "--json")).out)
    assert [one["id"] for one in whole["people"]] == [1, 2]


async def test_a_map_without_tracking_robots_says_so(ppaas: CommandLine) -> None:
    put_map(ppaas.services.map_store, house())
    ended = await ppaas("people", "house")
    assert ended.out == "house  no people are tracked: no robot tracks people on this map now\n"
    assert (await ppaas("people", "attic")).err == "ppaas: not-found: unknown map 'attic'\n"


async def test_people_are_watched_until_interrupted(watched: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    get, calls = RestClient.get, iter(range(2))

    async def interrupted(client: RestClient, path: str) -> Any:
        if next(calls, None) is None:
            raise KeyboardInterrupt
        return await get(client, path)

    monkeypatch.setattr(RestClient, "get", interrupted)
    ended = await watched("people", "house", "--watch", "--json", "--interval", "0.1")
    assert ended.status == 130
    assert [json.loads(line)["count"] for line in ended.out.splitlines()] == [2, 2]


async def test_the_live_view_draws_people_and_robots(watched: CommandLine) -> None:
    seen = json.loads((await watched("people", "house", "--json")).out)
    console = Console(width=160, file=io.StringIO(), record=True)
    console.print(render(seen))
    text = console.export_text()
    assert "Zoë" in text and "tb2" in text


async def test_people_are_followed_by_id_and_by_name(watched: CommandLine) -> None:
    named = await watched("people", "house", "--name", "1=Zoë Q", "--name", "2=Max", "--json")
    assert json.loads(named.out)["names"] == {"1": "Zoë Q", "2": "Max"}
    ended = await watched("people", "house", "--follow", "2", "Zoë Q")
    assert ended.rows[1][:3] == ["named", "2,", "1"]
    assert settings(watched).targets == [2, 1]
    assert (await watched("people", "house", "--follow", "-")).status == 0
    assert (settings(watched).rule, settings(watched).targets) == ("named", [])
    assert (await watched("people", "house", "--name", "2=")).status == 0
    assert settings(watched).names == {"1": "Zoë Q"}


async def test_the_rule_and_the_counting_are_changed(watched: CommandLine) -> None:
    changes = ("--rule", "longest_seen", "--followed-at-once", "2", "--count", "on", "--retention-hours", "48")
    assert (await watched("people", "house", *changes)).status == 0
    expected = PeopleSettings(rule="longest_seen", followed_at_once=2, history=True, retention_hours=48.0)
    assert settings(watched) == expected
    shown = await watched("people", "house", "--settings")
    assert shown.rows[1][0] == "longest_seen"
    assert (await watched("people", "house", "--count", "off")).status == 0
    assert not settings(watched).history


async def test_settings_are_put_from_a_file(watched: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "settings.json"
    file.write_text('{"zones": [{"name": "door", "corners": [[0, 0], [1, 0], [1, 1]]}], "history": true}')
    ended = await watched("people", "house", "--put", str(file))
    assert ended.rows[1][0] == "nearest" and "door" in ended.rows[1]
    assert settings(watched) == PeopleSettings(zones=[DOOR], history=True)
    file.write_text("{")
    assert "cannot read settings from" in (await watched("people", "house", "--put", str(file))).err
    assert settings(watched) == PeopleSettings(zones=[DOOR], history=True)


async def test_other_options_change_the_settings_of_a_file(watched: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "settings.json"
    file.write_text(json.dumps({"rule": "nearest", "followed_at_once": 2}))
    ended = await watched("people", "house", "--put", str(file), "--rule", "longest_seen")
    assert ended.status == 0
    assert (settings(watched).rule, settings(watched).followed_at_once) == ("longest_seen", 2)


async def test_counts_are_listed_and_forgotten(ppaas: CommandLine, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("endpoints.rest.people.people_history.epoch", lambda: float(RECENT))
    put_map(ppaas.services.map_store, house())
    store = ppaas.services.store
    assert "--count on" in (await ppaas("people", "house", "--history")).out
    store.put_people_settings(MapPeople("ann", "house", PeopleSettings(zones=[DOOR], history=True)))
    store.add_people_counts(
        PeopleCount("ann", "house", RECENT, zone, number) for number, zone in ((5, ""), (2, "door"))
    )
    ended = await ppaas("people", "house", "--history")
    assert [row[2:] for row in ended.rows[1:]] == [["(whole", "map)", "5"], ["door", "2"]]
    at_door = await ppaas("people", "house", "--history", "--zone", "door", "--json")
    assert json.loads(at_door.out) == [{"hour": RECENT, "zone": "door", "people": 2}]
    assert (await ppaas("people", "house", "--forget")).status == 0
    assert store.people_counts("ann", "house") == []


async def test_invalid_choices_are_reported_and_change_nothing(watched: CommandLine) -> None:
    reported = {
        ("--follow", "9"): "unknown person '9'; known: 1, 2",
        ("--name", "Zoë"): "is not ID=NAME",
        ("--rule", "tallest"): "unknown rule 'tallest'; known: longest_seen, named, nearest",
        ("--retention-hours", "0"): "greater than 0",
    }
    for arguments, why in reported.items():
        ended = await watched("people", "house", *arguments)
        assert ended.status == 1
        assert why in ended.err
    for arguments in (("--watch", "--history"), ("--follow", "1", "--rule", "nearest"), ("--count", "1")):
        assert (await watched("people", "house", *arguments)).status == 2
    assert settings(watched) == PeopleSettings()
