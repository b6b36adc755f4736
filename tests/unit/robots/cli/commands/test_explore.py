"""Command ``ppaas explore``: robots that cannot explore are refused with what to do."""

import json
from pathlib import Path

import pytest

from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Duration
from ppaas.messages.explore_msgs import ExploreFeedback, ExploreResult
from robots.cli.commands.explore import as_json
from robots.cli.explore_progress import ExploreProgress, line_of
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


def feedback(seconds: float, text: str, **numbers: float) -> ExploreFeedback:
    return ExploreFeedback(exploration_time=Duration.of(seconds), text=text, **numbers)  # type: ignore[arg-type]


def test_line_has_time_frontiers_area_distance_and_what_the_robot_does() -> None:
    told = feedback(75.0, "driving to a frontier at (1.0, 2.0)", frontiers=4, area=31.24, distance=12.06)
    assert line_of(told) == " 1m 15s  4 frontiers, 31.2 m² known, 12.1 m driven: driving to a frontier at (1.0, 2.0)"
    told.unreachable = 1
    assert "4 frontiers, 1 given up, " in line_of(told)


def test_control_characters_of_a_text_are_not_printed() -> None:
    assert "\x1b" not in line_of(feedback(1.0, "\x1b[2J"))


def test_same_text_is_repeated_every_five_seconds_only() -> None:
    lines: list[str] = []
    progress = ExploreProgress(lines.append)
    for second in range(12):
        progress(feedback(float(second), "driving" if second < 3 else "looking"))
    assert [line.split()[0] for line in lines] == ["0s", "3s", "8s"]
