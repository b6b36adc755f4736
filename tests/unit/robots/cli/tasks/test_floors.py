"""Tasks over floors at the command line: places with floors, and a mission that is rehearsed in a building."""

import json
from pathlib import Path
from typing import Any

import pytest

from ppaas.zones.reading import geojson_of
from ppaas.zones.shapes import Point
from ppaas.zones.zone import Station, Zone, ZoneSet
from tests.support.cloud.command_line import CommandLine
from tests.support.rmf import building
from tests.support.storage.records import house, put_map, robot


@pytest.fixture
async def inn(ppaas: CommandLine, tmp_path: Path) -> CommandLine:
    """Return the command line of ann: a building with a lift, a robot on the first floor, a station on the second."""
    file, zones = tmp_path / "inn.building.yaml", tmp_path / "zones.geojson"
    file.write_bytes(building())
    assert (await ppaas("building", "import", str(file))).status == 0
    ppaas.services.store.put_robot(robot("tb1", map="inn-L1", initial_pose=(5.0, 5.0, 0.0)))
    with ppaas.services.map_store.open_map("inn-L2") as opened:
        desk = Zone(Point([6.0, -2.0]), Station(name="the desk", yaw=1.0))
        zones.write_bytes(geojson_of(ZoneSet([*opened.zones().zones, desk])))
    assert (await ppaas("map", "zones", "inn-L2", "--put", str(zones))).status == 0
    return ppaas


async def add(inn: CommandLine, map_id: str, *words: str) -> Any:
    added = await inn("map", "task", "add", map_id, *words, "--json")
    return json.loads(added.out) if added.status == 0 else added.err


async def test_places_have_floors_before_them(inn: CommandLine) -> None:
    places = ["--at", "5", "5", "--at", "L2:5,5,1.5", "--at", "L2:the", "desk", "--at", "L2:4", "5"]
    added = await add(inn, "inn-L1", "patrol", *places)
    assert added["places"] == [[5.0, 5.0, 0.0], [5.0, 5.0, 1.5], [6.0, -2.0, 1.0], [4.0, 5.0, 0.0]]
    assert added["floors"] == ["L1", "L2", "L2", "L2"]
    assert (await add(inn, "inn-L1", "go_to", "--at", "5", "5"))["floors"] == []
    assert "the map inn-L2 has no station 'the dusk'; do you mean 'the desk'?" in await add(
        inn, "inn-L1", "go_to", "--at", "L2:the dusk"
    )
    assert "has no station 'L9:5,5'" in await add(inn, "inn-L1", "go_to", "--at", "L9:5,5")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """Return the file of a mission over floors."""
    tasks = [
        {"name": "up", "kind": "pick_drop", "at": [[5, 5], {"floor": "L2", "at": "the desk"}]},
        {"name": "down", "kind": "go_to", "at": ["door"], "after": [{"task": "up"}]},
    ]
    path = tmp_path / "mission.json"
    path.write_text(json.dumps({"map": "inn-L1", "places": {"door": {"floor": "L1", "at": [5, 5]}}, "tasks": tasks}))
    return path


async def test_a_mission_over_floors_is_rehearsed_by_the_times_of_the_building(
    inn: CommandLine, file: Path, tmp_path: Path
) -> None:
    picture = tmp_path / "mission.png"
    ended = await inn("task", "run", str(file), "--dry-run", "--picture", str(picture))
    assert (ended.status, ended.err) == (0, "")
    assert ended.rows[0][:4] == ["task", "robot", "floors", "set_out"]
    assert picture.read_bytes().startswith(b"\x89PNG")
    rows = {row["task"]: row for row in json.loads((await inn("task", "run", str(file), "--dry-run", "--json")).out)}
    assert (rows["up"]["floors"], rows["up"]["state"], rows["down"]["state"]) == ("L1 → L2", "done", "done")
    ends = ("L1:5,5,0", "L2:6,-2,1")
    there = json.loads((await inn("building", "plan", "inn", *ends, "--json")).out)["seconds"]
    back = json.loads((await inn("building", "plan", "inn", *reversed(ends), "--json")).out)["seconds"]
    assert rows["up"]["finish"] == pytest.approx(there, abs=0.2)
    assert rows["down"]["finish"] - rows["up"]["finish"] == pytest.approx(back, abs=0.2)


async def test_a_mission_over_floors_is_added_with_floors(inn: CommandLine, file: Path) -> None:
    ended = await inn("task", "run", str(file), "--json")
    assert {row["task"]: row["floors"] for row in json.loads(ended.out)} == {"up": ["L1", "L2"], "down": ["L1"]}


def edit(file: Path, before: str, after: str) -> None:
    file.write_text(file.read_text().replace(before, after))


async def test_floors_that_do_not_exist_are_refused(inn: CommandLine, file: Path) -> None:
    edit(file, '"L2"', '"roof"')
    assert "building inn has no floor 'roof'; it has L1, L2" in (await inn("task", "run", str(file))).err
    put_map(inn.services.map_store, house())
    edit(file, "inn-L1", "house")
    assert "the map house is no floor of a building" in (await inn("task", "run", str(file))).err
