"""The page about leaving again: its commands, its files and its tables are those of the code."""

import re
from pathlib import Path

import pytest

from ppaas.controllers.registry import CONTROLLERS
from ppaas.exports.ros2.driving import PLUGINS
from ppaas.exports.ros2.releases import Release
from ppaas.zones.zone import KINDS
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import run_shell, script, table, text_of

PAGE = "docs/export-ros2.md"


def named(text: str) -> set[str]:
    return set(re.findall(r"`([\w.]+)`", text))


def test_planners_controllers_zones_and_releases_are_those_of_the_code() -> None:
    here = [row[0] for row in table(PAGE, "here", "in Nav2")]
    assert named(here[0]) | named(here[1]) == set(PLUGINS)
    assert named(here[2]) == set(CONTROLLERS.names())
    page = text_of(PAGE)
    assert all(f"`{release.value}`" in page for release in Release)
    assert set(KINDS) <= named(page)


@pytest.mark.journey
def test_the_shell_commands_work(own_cloud: RunningCloud, tmp_path: Path) -> None:
    [login] = [line for line in script("README.md").splitlines() if line.startswith("export PPAAS_TOKEN")]
    printed = run_shell(f"{login}\n{script(PAGE)}", tmp_path, own_cloud)
    assert "tb1-ros2" in printed
    written = {path.name for path in (tmp_path / "tb1-ros2").iterdir()}
    listed = {name for row in table(PAGE, "file", "what it has") for name in re.findall(r"[\w.]+\.\w+", row[0])}
    assert listed - written == {"robot.urdf", "docks.yaml"}, "tb1 has no URDF, and its map no docks"
    assert {name for name in written - listed if not name.endswith(".pgm")} == set()
