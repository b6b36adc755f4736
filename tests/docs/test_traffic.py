"""The page about traffic: its numbers, parameters and states are those of the code."""

import re
from typing import get_args

import msgspec
import pytest

from engine.control import traffic_groups
from ppaas.clone.driving import DrivingInTraffic
from ppaas.nodes.granted_move_base.traffic_link import NODE_SILENCE
from ppaas.traffic.granted_way import STRAY
from ppaas.traffic.members import Standing
from ppaas.traffic.settings import TrafficParameters
from ppaas.traffic.taking_part import takes_part
from robots.cli.command_parser import CommandParser
from robots.cli.commands import demo as demo_command
from robots.cli.commands import map as map_command
from robots.cli.commands import robot as robot_command
from robots.client.robot_file import RobotFile
from tests.support.documents import blocks, table, text_of

PAGE = "docs/traffic.md"
VALUES = TrafficParameters()


@pytest.fixture(scope="module")
def page() -> str:
    """Return the text of the page, in one line."""
    return re.sub(r"\s+", " ", text_of(PAGE))


def test_the_robot_file_of_the_page_takes_part() -> None:
    [block] = blocks(PAGE, "json")
    assert takes_part(msgspec.json.decode(block, type=RobotFile).parameters)


def test_parameters_are_those_of_the_code() -> None:
    listed = {
        name.strip("`"): float(value) for name, value, _ in table(PAGE, "parameter of `traffic`", "default", "meaning")
    }
    assert listed == msgspec.to_builtins(DrivingInTraffic())


def test_the_margin_and_the_width_of_the_way_are_those_of_the_code(page: str) -> None:
    assert f"two margins of {VALUES.margin:g} m" in page and f"the margin of {VALUES.margin:g} m" in page
    assert page.count(f"more than {STRAY:g} of the width of a cell") == 2


def test_times_are_those_of_the_code(page: str) -> None:
    assert f"ends it {traffic_groups.TRAFFIC_LINGER:g} s after the last one has left" in page
    assert f"drives freely stops after {NODE_SILENCE:g} s" in page
    assert f"granted nothing after {VALUES.silence:g} s, and keeps what it holds for {VALUES.forget:g} s" in page
    assert f"does not get on for {VALUES.patience:g} s" in page
    assert f"has not reported for {VALUES.patience:g} s" in page
    first, *others = (VALUES.retry * 2**tries for tries in range(4))
    assert f"after {first:g} s, then after {others[0]:g} s, {others[1]:g} s and {others[2]:g} s" in page
    assert f"around the cell for {VALUES.keep_blocked:g} s" in page


OTHER_STATES = {"driving", "waiting", "idle", "free", "no_cells", "docking", "docked"}


def test_states_are_those_of_the_code() -> None:
    states = [state.strip("`") for state, _ in table(PAGE, "state", "meaning")]
    assert set(states) == {*OTHER_STATES, *get_args(Standing)} - {"joined"}


def test_the_commands_of_the_page_are_valid() -> None:
    lines = [line.split() for block in blocks(PAGE, "sh") for line in block.splitlines()]
    parsers = {name: CommandParser() for name in ("map", "robot", "demo")}
    map_command.configure(parsers["map"])
    robot_command.configure(parsers["robot"])
    demo_command.configure(parsers["demo"])
    assert len(lines) >= 8
    for ppaas, command, *words in lines:
        parsed = parsers[command].parse_args(words)
        assert ppaas == "ppaas" and words[0] in {getattr(parsed, "verb", ""), getattr(parsed, "show", "")}
