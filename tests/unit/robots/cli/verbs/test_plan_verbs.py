"""Verbs of ``ppaas plan``: the path plan database, and matrices of costs."""

import json
from pathlib import Path

import numpy as np
import pytest

from ppaas.geometry import poses_along
from robots.plans.matrix import answer_of
from tests.support.cloud.command_line import CommandLine
from tests.support.sources import ROOT
from tests.support.storage.records import house, put_map
from tests.support.world import grids

POSES = poses_along(np.stack((np.arange(60) * 0.05, np.zeros(60)), axis=1), 0.0).tolist()
BETWEEN = ("house", "--start", "0", "0", "--goal", "2.95", "-0.1")


@pytest.fixture
def file(ppaas: CommandLine, tmp_path: Path) -> str:
    put_map(ppaas.services.map_store, house())
    path = tmp_path / "plan.json"
    path.write_text(json.dumps({"map": "house", "planner": "astar", "poses": POSES}))
    return str(path)


async def test_stored_paths_are_put_found_changed_and_described(ppaas: CommandLine, file: str) -> None:
    assert "no stored paths between" in (await ppaas("plan", "find", *BETWEEN)).out
    for plan_id in ("one", "two"):
        ended = await ppaas("plan", "put", plan_id, file)
        assert ended.status == 0, ended.err
    found = await ppaas("plan", "find", *BETWEEN)
    assert [row[0] for row in found.rows] == ["plan_id", "one", "two"]
    assert (await ppaas("plan", "find", *BETWEEN, "--planner", "jps")).out.startswith("no stored paths")
    assert len((await ppaas("plan", "find", *BETWEEN, "--limit", "1")).rows) == 2
    assert (await ppaas("plan", "set", "one", "cost=4.5", "parameters.weight=2")).status == 0
    assert ppaas.services.store.plan("one").parameters == {"weight": 2}
    parts = json.loads((await ppaas("plan", "parts", "one", "--json")).out)
    assert sum(part["count"] for part in parts) == 57
    assert (await ppaas("plan", "statistics", "house")).rows[1][:2] == ["2", "120"]


async def test_invalid_files_and_queries_are_reported(ppaas: CommandLine, file: str, tmp_path: Path) -> None:
    assert "No such file" in (await ppaas("plan", "put", "one", str(tmp_path / "none.json"))).err
    (tmp_path / "bad.json").write_text("{")
    assert "is not JSON" in (await ppaas("plan", "put", "one", str(tmp_path / "bad.json"))).err
    assert "tolerance" in (await ppaas("plan", "find", *BETWEEN, "--tolerance", "9")).err
    assert "unknown plan" in (await ppaas("plan", "parts", "none")).err


OFFICE = str(ROOT / "docs" / "examples" / "office.yaml")
ENDS = {"starts": [[2, 2], [10.0, 8.0]], "goals": [[10, 2], [2, 8], [2, 2]]}


def written(folder: Path, ends: object) -> str:
    file = folder / "ends.json"
    file.write_text(json.dumps(ends))
    return str(file)


async def test_costs_are_shown_by_numbers_of_starts_and_goals(ppaas: CommandLine, tmp_path: Path) -> None:
    ended = await ppaas("plan", "matrix", OFFICE, written(tmp_path, ENDS), user=None)
    assert ended.status == 0, ended.err
    assert ended.rows[0] == ["start", "goal", "0", "goal", "1", "goal", "2"]
    assert [row[0] for row in ended.rows[1:]] == ["0", "1"]
    assert ended.rows[1][3] == "0"


async def test_matrix_costs_equal_the_costs_of_plans(ppaas: CommandLine, tmp_path: Path) -> None:
    ended = await ppaas("plan", "matrix", OFFICE, written(tmp_path, ENDS), "--radius", "0.2", "--json", user=None)
    matrix = json.loads(ended.out)
    assert matrix["seconds"] > 0.0
    plan = ("plan", OFFICE, "--start", "2", "2", "--goal", "2", "8", "--radius", "0.2", "--json")
    assert matrix["costs"][0][1] == pytest.approx(json.loads((await ppaas(*plan)).out)["cost"], rel=2e-4)


def test_an_unreachable_goal_has_no_cost() -> None:
    assert answer_of(grids.costmap(".#."), {"starts": [[0.5, 0.5]], "goals": [[0.5, 0.5], [2.5, 0.5]]})["costs"] == [
        [0.0, None]
    ]


@pytest.mark.parametrize(
    ("ends", "why"),
    [
        ([], "must be a JSON object with starts and goals"),
        ({"starts": [[2, 2]]}, "must be a JSON object with starts and goals"),
        ({"starts": [[2, 2]], "goals": [["here", 2]]}, "must be a JSON object with starts and goals"),
        ({"starts": [[2, 2]], "goals": [[2, 2, 0.5], [2, 2]]}, "goals must be rows of x, y"),
        ({"starts": [[2, 2]], "goals": [[200, 2]]}, "goal-outside-map"),
    ],
)
async def test_invalid_starts_and_goals_are_refused(ppaas: CommandLine, tmp_path: Path, ends: object, why: str) -> None:
    ended = await ppaas("plan", "matrix", OFFICE, written(tmp_path, ends), user=None)
    assert (ended.status, ended.out) == (1, "")
    assert why in ended.err


async def test_a_missing_file_is_reported(ppaas: CommandLine, tmp_path: Path) -> None:
    ended = await ppaas("plan", "matrix", OFFICE, str(tmp_path / "none.json"), user=None)
    assert ended.err.startswith("ppaas: invalid-input: cannot read starts and goals")
