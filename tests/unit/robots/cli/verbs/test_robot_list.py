"""Lists of robots with their states: columns, order and search."""

import json
from pathlib import Path
from typing import Any

from engine.protocols.robot_link import ContainerBeat
from engine.specs.robot_report import StateReport
from ppaas.clock import epoch
from ppaas.messages.actionlib_msgs import Status
from robots.cli.verbs.robot_list import LONGEST, in_order, matching, short
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.fake_cloud import container
from tests.support.endpoints.still_place import StillRobot
from tests.support.storage.records import house, put_map


def robot(name: str, **state: Any) -> dict[str, Any]:
    return {"id": name, "state": "online", "battery": None, "task": "", "error": "", "map": "house"} | state


def ids(robots: list[dict[str, Any]]) -> list[str]:
    return [one["id"] for one in robots]


def test_robots_are_sorted_by_numbers_in_names_and_what_is_not_known_comes_last() -> None:
    assert ids(in_order([robot("tb10"), robot("tb9"), robot("a")], "id")) == ["a", "tb9", "tb10"]
    charged = [robot("a"), robot("b", battery=1.0), robot("c", battery=0.09), robot("d", battery=0.0)]
    assert ids(in_order(charged, "battery")) == ["d", "c", "b", "a"]
    assert ids(in_order(charged, "battery", falls=True)) == ["b", "c", "d", "a"]
    assert ids(in_order([robot("a"), robot("b", error="x")], "error", falls=True)) == ["b", "a"]


def test_each_word_of_a_search_is_found_in_any_column() -> None:
    robots = [robot("tb1", error="There is no way"), robot("tb2", map="Attic")]
    assert ids(matching(robots, "NO house")) == ["tb1"]
    assert ids(matching(robots, "attic online")) == ["tb2"]
    assert ids(matching(robots, "attic way")) == []
    assert ids(matching(robots, " ")) == ["tb1", "tb2"]


def test_long_texts_are_cut_for_a_terminal() -> None:
    cut = short(robot("tb1", task="t" * LONGEST, error="e" * (LONGEST + 1)))
    assert (cut["task"], cut["error"]) == ("t" * LONGEST, "e" * (LONGEST - 1) + "…")
    assert short(robot("tb1", task=None))["task"] is None


async def test_robots_are_listed_with_their_states(ppaas: CommandLine, tmp_path: Path) -> None:
    file = tmp_path / "tb1.json"
    file.write_text(json.dumps({"map": "house"}))
    put_map(ppaas.services.map_store, house())
    for name in ("tb1", "tb2"):
        await ppaas("robot", "put", name, str(file))
    ppaas.cloud.running = [container("c1", machine="m7")]
    ppaas.cloud.connect("ann", "tb1", place := StillRobot())
    report = StateReport(pose_at=epoch(), goal=Status.ACTIVE, left=4.0, battery=0.8, software="acme 3.2")
    place.take(ContainerBeat(busy=True, robot=True, report=report))
    listed = await ppaas("robot", "list")
    assert listed.rows[0] == ["id", "state", "battery", "seen_ago", "task", "error"]
    assert listed.rows[1] == ["tb1", "online", "80", "%", "now", "Driving,", "4.0", "m", "to", "go"]
    wide = await ppaas("robot", "list", "--wide")
    assert {"m7", "acme", "3.2"} <= set(wide.rows[1])
    fallen = await ppaas("robot", "list", "--sort", "id", "--reverse", "--json")
    assert ids(json.loads(fallen.out)) == ["tb2", "tb1"]
    assert ids(json.loads((await ppaas("robot", "list", "--filter", "ACME", "--json")).out)) == ["tb1"]
    assert (await ppaas("robot", "list", "--filter", "nobody")).out == "no robot is found\n"
