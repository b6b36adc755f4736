"""Command ``ppaas explore``: robots that cannot explore are refused with what to do."""

import json
from pathlib import Path

import pytest

from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Duration
from ppaas.messages.explore_msgs import ExploreResult
from robots.cli.commands.explore import as_json
from robots.client.explore import ExploreOutcome
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map


@pytest.fixture
def file(tmp_path: Path, ppaas: CommandLine) -> Path:
    put_map(ppaas.services.map_store, house())
    return tmp_path / "tb1.json"


def written(file: Path, used: str) -> str:
    file.write_text(json.dumps({"map": used}))
    return str(file)


async def put(ppaas: CommandLine, file: Path, used: str) -> None:
    assert (await ppaas("robot", "put", "tb1", written(file, used))).status == 0


async def test_robot_on_a_published_map_has_nothing_to_explore(ppaas: CommandLine, file: Path) -> None:
    await put(ppaas, file, "house")
    refused = await ppaas("explore", "tb1")
    assert refused.status == 1
    assert "robot 'tb1' drives on the published map 'house': there is nothing to explore" in refused.err
    assert "ppaas robot change tb1 map=new:NAME, and connect the robot again" in refused.err


async def test_robot_that_is_not_connected_is_to_be_started(ppaas: CommandLine, file: Path) -> None:
    await put(ppaas, file, "new:house-2")
    assert "robot 'tb1' is not connected: start it, and explore again" in (await ppaas("explore", "tb1")).err
    await put(ppaas, file, "house")
    assert "robot 'tb1' is not connected" in (await ppaas("explore", "tb1", "--anyway")).err


async def test_unknown_robot_is_refused(ppaas: CommandLine) -> None:
    assert "tb1" in (await ppaas("explore", "tb1")).err


def test_outcome_is_an_object_of_json() -> None:
    outcome = ExploreOutcome(Status.SUCCEEDED, "No frontier is left.", ExploreResult(0, 1, 12.345, 6.78, Duration(9)))
    assert as_json(outcome) == {
        "state": "succeeded", "text": "No frontier is left.", "frontiers": 0, "unreachable": 1,
        "area": 12.35, "distance": 6.78, "seconds": 9.0,
    }  # fmt: skip
