"""``ppaas task``: missions are rehearsed, run and waited for."""

import json
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from engine.control.views import ReportedRobot
from engine.specs.robot_report import StateReport
from ppaas.planners.weights import NEUTRAL
from robots.cli.tasks import task
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map, robot

MISSION: dict[str, Any] = {
    "map": "house",
    "places": {"shelf": [1.0, 2.0], "desk": [3.0, 4.0]},
    "tasks": [
        {"name": "after", "kind": "go_to", "at": ["desk"], "after": [{"task": "first"}]},
        {
            "name": "first",
            "kind": "pick_drop",
            "at": ["shelf", "desk"],
            "holds": [None, {"seconds": 5}],
            "deadline": 20,
        },
    ],
}


@pytest.fixture
def office(ppaas: CommandLine, monkeypatch: pytest.MonkeyPatch) -> CommandLine:
    """Return the command line of ann, who has a robot at the origin of the map house."""
    put_map(ppaas.services.map_store, house())
    ppaas.services.store.put_robot(robot("tb1"))

    async def views(robots: list[tuple[str, str]]) -> list[ReportedRobot]:
        return [ReportedRobot(True, report=StateReport(pose=(0.0, 0.0, 0.0))) for _ in robots]

    monkeypatch.setattr(ppaas.cloud, "robot_views", views)
    return ppaas


@pytest.fixture
def file(tmp_path: Path) -> str:
    """Return the file of a mission."""
    path = tmp_path / "mission.json"
    path.write_text(json.dumps(MISSION))
    return str(path)


async def test_a_dry_run_prints_a_time_table_by_the_ways_of_the_map_and_adds_nothing(
    office: CommandLine, file: str
) -> None:
    ended = await office("task", "run", file, "--dry-run")
    assert ended.err == ""
    assert ended.rows[0][:3] == ["task", "robot", "set_out"]
    # the fake cloud has 50 m for each way but those to the first goal, the shelf, which do not exist
    assert "0 of 2 tasks done" in ended.out
    assert "no robot could begin it before its deadline" in ended.out
    assert "task 'first' is failed: this task was to begin after it is done" in ended.out
    assert office.services.store.tasks("ann", "house") == []


async def test_times_of_a_dry_run_are_those_of_ways_and_holds(office: CommandLine, tmp_path: Path) -> None:
    path = tmp_path / "mission.json"
    reordered = MISSION["tasks"][0] | {"after": [], "at": [[9.0, 9.0]], "name": "elsewhere", "priority": -50}
    path.write_text(json.dumps(MISSION | {"tasks": [reordered, MISSION["tasks"][1]]}))
    picture = tmp_path / "mission.png"
    words = ["--dry-run", "--json", "--picture", str(picture)]
    office.cloud.path_cost = 50.0 * NEUTRAL / 0.05  # 50 m on cells of 5 cm
    found = json.loads((await office("task", "run", str(path), *words)).out)
    assert picture.read_bytes().startswith(b"\x89PNG")
    rows = {row["task"]: row for row in found}
    assert rows["first"]["state"] == "done"
    assert rows["first"]["begin"] == pytest.approx(100.0, abs=0.2)  # 50 m
    assert rows["first"]["finish"] == pytest.approx(205.0, abs=0.2)
    assert rows["first"]["late"] is True


async def test_a_mission_is_added_in_order_with_the_ids_of_its_tasks(office: CommandLine, file: str) -> None:
    ended = await office("task", "run", file, "--json")
    assert ended.err == ""
    added = {row["task"]: row for row in json.loads(ended.out)}
    assert added["after"]["after"] == [{"task": added["first"]["id"], "on": "done"}]
    assert added["first"]["holds"] == [None, {"seconds": 5.0}]
    assert len(office.services.store.tasks("ann", "house")) == 2


@pytest.mark.parametrize(("state", "status"), [("done", 0), ("failed", 1)])
async def test_a_command_waits_for_the_end_of_a_mission(
    office: CommandLine, file: str, monkeypatch: pytest.MonkeyPatch, state: str, status: int
) -> None:
    monkeypatch.setattr(task, "POLL", 0.01)

    async def end(user: str, map_id: str) -> None:
        for kept in office.services.store.tasks(user, map_id):
            times = {"assigned": kept.task.created, "begun": kept.task.created + 1.0, "ended": kept.task.created + 2.0}
            office.services.store.put_task(replace(kept, task=replace(kept.task, state=state, robot="tb1", **times)))

    monkeypatch.setattr(office.cloud.tasks, "changed", end)
    ended = await office("task", "run", file, "--wait")
    assert ended.status == status
    assert ("2 of 2 tasks done" in ended.out) == (state == "done")
    assert ("not done: first, after" in ended.err) == (state == "failed")


async def test_what_is_wrong_is_refused(office: CommandLine, file: str, tmp_path: Path) -> None:
    for words, advice in (
        (["run", str(tmp_path / "none.json")], "cannot read"),
        (["run", file, "--picture", "x.png"], "--dry-run or --wait"),
        (["run", file, "--dry-run", "--picture", "x.jpg"], ".png"),
    ):
        ended = await office("task", *words)
        assert (ended.status, advice in ended.err) == (1, True), ended.err
    office.services.store.remove_robot("ann", "tb1")
    assert "no robot on the map" in (await office("task", "run", file, "--dry-run")).err


async def test_the_schema_is_printed(office: CommandLine) -> None:
    assert "MissionTask" in json.loads((await office("task", "schema")).out)["$defs"]
