"""The commands of stop.md work, and its numbers and names are those of the code."""

import re
import shlex

from engine.control.robot_stops import CONFIRMATION
from ppaas.nodes.stop.node import PERIOD, StopNode
from ppaas.nodes.topics import STOP_STATE
from robots.cli.command_parser import CommandParser
from robots.cli.stops import release, stop
from tests.support.documents import blocks, text_of
from tests.support.endpoints.fuzzed_rest import description

PAGE = "docs/stop.md"


def test_the_commands_are_accepted() -> None:
    commands = [line for block in blocks(PAGE, "bash") for line in block.splitlines() if line.startswith("ppaas ")]
    assert {line.split()[1] for line in commands} == {"stop", "release"}
    for line in commands:
        _, command, *words = shlex.split(line, comments=True)
        parser = CommandParser()
        {"stop": stop, "release": release}[command].configure(parser)
        parser.parse_args(words)


def test_paths_names_and_numbers_exist() -> None:
    text = text_of(PAGE)
    paths = {path.replace("{robot_id}", "ID").replace("{map_id}", "ID") for path in description()["paths"]}
    assert set(re.findall(r"`(?:GET )?(/v1/[\w/]*(?:stops?))`", text)) <= paths
    assert {f"`{STOP_STATE.name}`", f"`{StopNode.services[0].name}`"} <= set(re.findall(r"`stop/\w+`", text))
    assert (1.0 / PERIOD, CONFIRMATION) == (5.0, 1.0), "five times a second; within a second"
