"""Command ``ppaas export ros2``: the files of a set-up, and its report."""

import json
from pathlib import Path

import pytest
import yaml

from ppaas.exports.ros2.releases import Release
from robots.cli.exports import export
from tests.support.cloud.command_line import CommandLine
from tests.support.storage.records import house, put_map


@pytest.fixture
async def robot(ppaas: CommandLine, tmp_path: Path) -> Path:
    """Put a robot on a map that ann has published; return a folder."""
    put_map(ppaas.services.map_store, house())
    file = tmp_path / "tb1.json"
    file.write_text(
        json.dumps({"map": "house", "parameters": {"dwa": {"max_vel_x": 0.4}, "teleop": {"max_rate": 5.0}}})
    )
    assert (await ppaas("robot", "put", "tb1", str(file))).status == 0
    return tmp_path


def test_the_command_offers_all_releases() -> None:
    assert list(export.RELEASES) == [each.value for each in Release]


async def test_a_robot_is_written_with_its_map(ppaas: CommandLine, robot: Path) -> None:
    ended = await ppaas("export", "ros2", "tb1", "--out", str(robot / "out"), "--release", "humble")
    assert ended.status == 0, ended.err
    files = {path.name for path in (robot / "out").iterdir()}
    assert {"nav2_params.yaml", "slam_toolbox_params.yaml", "map.yaml", "map.pgm", "bringup.launch.py"} <= files
    server = yaml.safe_load((robot / "out" / "nav2_params.yaml").read_text())["controller_server"]["ros__parameters"]
    assert server["FollowPath"]["max_vel_x"] == 0.4
    assert "teleop.max_rate" in ended.err
    assert ended.err.splitlines()[-1].startswith("tb1: ")
    assert "humble" in ended.out


async def test_a_dry_run_writes_nothing_and_json_is_for_programs(ppaas: CommandLine, robot: Path) -> None:
    ended = await ppaas("export", "ros2", "tb1", "--out", str(robot / "out"), "--dry-run", "--json")
    assert (ended.status, ended.out, (robot / "out").exists()) == (0, "", False)
    report = json.loads(ended.err)
    assert report["source"] == "tb1"
    assert {entry["part"]: entry["outcome"] for entry in report["entries"]}["teleop.max_rate"] == "no effect"
    written = await ppaas("export", "ros2", "tb1", "--out", str(robot / "out"), "--json")
    assert json.loads(written.out)["files"] == sorted(path.name for path in (robot / "out").iterdir())


async def test_a_robot_that_is_not_there_and_a_folder_that_cannot_be(ppaas: CommandLine, robot: Path) -> None:
    missing = await ppaas("export", "ros2", "tb9")
    assert (missing.status, "tb9" in missing.err) == (1, True)
    (robot / "file").write_text("")
    refused = await ppaas("export", "ros2", "tb1", "--out", str(robot / "file"))
    assert (refused.status, "cannot write to" in refused.err) == (1, True)


async def test_a_robot_that_makes_its_map_needs_none(ppaas: CommandLine, robot: Path) -> None:
    changed = await ppaas("robot", "change", "tb1", "map=new:office-2")
    assert changed.status == 0, changed.err
    assert (await ppaas("export", "ros2", "tb1", "--out", str(robot / "out"))).status == 0
    assert not (robot / "out" / "map.yaml").exists()
