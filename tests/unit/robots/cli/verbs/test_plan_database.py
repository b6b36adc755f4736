"""``ppaas plan``: verbs of the path plan database."""

import json
from pathlib import Path

import numpy as np
import pytest

from ppaas.geometry import poses_along
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map

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
