"""The page about Nav2: what it has its reader type works, and its table is the one of the code."""

import json
from pathlib import Path

import pytest

from ppaas.imports.parameters.nav2.catalogue import NODES
from ppaas.imports.report import ImportOutcome
from robots.cli.command_parser import CommandParser
from robots.cli.commands import robot
from tests.support.cloud.cloud import RunningCloud
from tests.support.documents import run_shell, script, table

PAGE = "docs/from-nav2.md"


def test_the_plug_ins_are_those_of_the_code() -> None:
    found = {
        each.plugin: each.becomes
        for node in NODES
        for group in node.groups
        for each in group.tables
        if each.becomes and not each.plugin.startswith("nav2_recoveries")  # names before Humble
    }
    assert {plugin: ours for plugin, ours, _ in table(PAGE, "Nav2", "becomes", "")} == found


def test_the_outcomes_and_options_are_those_of_the_code() -> None:
    assert [outcome for outcome, _ in table(PAGE, "outcome", "meaning")] == [each.value for each in ImportOutcome]
    parser = CommandParser("robot")
    robot.configure(parser)
    put = vars(parser.parse_args(["put", "tb4", "--dry-run"]))
    names = {option.split()[0][2:].replace("-", "_") for option, _ in table(PAGE, "option", "meaning")}
    assert names <= put.keys()


@pytest.mark.journey
def test_the_robot_is_registered_as_the_page_types_it(cloud: RunningCloud, tmp_path: Path) -> None:
    out = run_shell(script(PAGE), tmp_path, cloud)
    assert out.splitlines()[-1].startswith("tb4")
    file = json.loads((tmp_path / "tb4.json").read_text())
    assert (file["map"], file["base_local_planner"]) == ("office", "dwa")
