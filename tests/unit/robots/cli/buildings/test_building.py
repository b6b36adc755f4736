"""Command ``ppaas building``: buildings from their first version to their end."""

import json
from pathlib import Path

import pytest
from PIL import Image

from storage.buildings.records import BuildingRecord
from tests.support.cloud.command_line import CommandLine
from tests.support.rmf import building

IMPORT = ("building", "import")


@pytest.fixture
async def line(ppaas: CommandLine, tmp_path: Path) -> CommandLine:
    """Return the command line of ann, who has imported a building of two floors."""
    file = tmp_path / "inn.building.yaml"
    file.write_bytes(building())
    answer = await ppaas(*IMPORT, str(file))
    assert answer.status == 0, answer.err
    return ppaas


def only(line: CommandLine) -> BuildingRecord:
    [record] = line.services.store.buildings("ann")
    return record


async def test_a_building_is_shown_changed_checked_and_removed(line: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "inn.json"
    assert (await line("building", "show", "inn", "--out", str(file))).status == 0
    given = json.loads(file.read_text())
    assert [floor["name"] for floor in given["floors"]] == ["L1", "L2"]
    given["lifts"] = [{"lift": "north", "wait": 45.0}, {"lift": "south"}]
    file.write_text(json.dumps(given))
    checked = await line("building", "check", "inn", str(file))
    assert checked.rows[1] == ["2", "1", "0", "4", "2"]
    assert "warning: no two maps have a landing of lift 'south'" in checked.out
    assert only(line).present.number == 1
    put = await line("building", "put", "inn", str(file), "--message", "slow doors", "--if-match", "1")
    assert put.rows[1][:3] == ["inn", "ann", "2"] and "'south'" in put.out
    assert (await line("building", "put", "inn", str(file), "--if-match", "1")).status == 1
    assert [row[0] for row in (await line("building", "versions", "inn")).rows[1:]] == ["2", "1"]
    old = json.loads((await line("building", "show", "inn", "--version", "1", "--json")).out)
    assert (old["version"], old["building"]["lifts"]) == (1, [{"lift": "north"}])
    assert (await line("building", "list")).rows[1][:3] == ["inn", "ann", "2"]
    assert (await line("building", "remove", "inn", "--if-match", "2")).status == 0
    assert "ppaas building import" in (await line("building", "list")).out


async def test_readers_are_named(line: CommandLine) -> None:
    assert (await line("building", "share", "inn", "--reader", "*")).status == 0
    assert only(line).readers == ("*",)
    assert (await line("building", "share", "inn", "--reader", "-")).status == 0
    assert only(line).readers == ()


async def test_its_places_are_listed_and_drawn(line: CommandLine, tmp_path: Path) -> None:
    picture = tmp_path / "inn.png"
    answer = await line("building", "layout", "inn", "--picture", str(picture))
    rows = {tuple(row[:2]) for row in answer.rows[1:]}
    assert {("lift", "north"), ("door", "office"), ("dock", "charger")} <= rows
    found = json.loads((await line("building", "layout", "inn", "--json")).out)
    assert (len(found["lifts"]["north"]), found["warnings"]) == (2, [])
    with Image.open(picture) as drawn:
        assert drawn.width > 2 * 280
    wrong = await line("building", "layout", "inn", "--picture", "inn.jpg")
    assert wrong.status == 1 and ".png" in wrong.err


async def test_a_file_that_is_no_building_is_refused(ppaas: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "x.json"
    missing = await ppaas("building", "put", "inn", str(file))
    assert missing.status == 1 and f"cannot read {file}" in missing.err
    file.write_text("{}")
    refused = await ppaas("building", "put", "inn", str(file))
    assert refused.status == 1 and "must have floors" in refused.err
