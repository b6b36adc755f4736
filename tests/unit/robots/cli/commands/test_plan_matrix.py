import json
from pathlib import Path

import pytest

from robots.plans.matrix import answer_of
from tests.support.cloud.command_line import CommandLine
from tests.support.sources import ROOT
from tests.support.world import grids

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
