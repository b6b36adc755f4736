"""Options and numbers in vda5050-agvs.md are those of the code."""

import argparse
import json
import re

import pytest

from engine.master.places import LINGER
from ppaas.wire.vda5050.master.route import TOLERANCE
from ppaas.wire.vda5050.master.settings import TRIES, Settings
from robots.bridges.agv.agv_robot import FORWARDED, LEAVE_AFTER
from robots.bridges.agv.options import MAJORS, OWN_MANUFACTURER
from robots.bridges.agv.registration import CORES
from robots.bridges.cli import agv
from robots.client.robot_file import parse_robot_file
from tests.support.documents import blocks, table, text_of

PAGE = "docs/vda5050-agvs.md"
ELSEWHERE = {"--help", "--url", "--ca-file", "--token", "--password-file", "--broker-ca-file"}
"""Options that all bridges have."""


def states(words: str) -> bool:
    return words in re.sub(r"\s+", " ", text_of(PAGE))


@pytest.fixture(scope="module")
def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser()
    agv.configure(made)
    return made


def test_the_options_are_those_of_the_command(parser: argparse.ArgumentParser) -> None:
    listed = {option.strip("`").split()[0] for option, _ in table(PAGE, "option", "meaning")}
    known = {action.option_strings[-1] for action in parser._actions if action.option_strings}
    assert listed == known - ELSEWHERE
    meanings = dict(table(PAGE, "option", "meaning"))
    usual = Settings()
    assert f"({usual.base_length:g} m)" in meanings["--base M"]
    assert f"({usual.deviation:g} m)" in meanings["--deviation M"]
    given = parser.parse_args(["--broker", "mqtt://broker"])
    assert (given.base, given.deviation) == (usual.base_length, usual.deviation)
    assert meanings["--interface NAME"].endswith(f"`{MAJORS['v2']}` (2.x) and `{MAJORS['v3']}` (3.0)")


def test_the_command_of_the_page_is_one(parser: argparse.ArgumentParser) -> None:
    (command,) = (line for line in text_of(PAGE).splitlines() if line.startswith("ppaas bridge agv"))
    given = parser.parse_args(command.split()[3:])
    assert given.map == [("hall-1", "office")]


def test_the_file_of_the_page_is_one() -> None:
    (block,) = blocks(PAGE, "json")
    assert parse_robot_file(block).cores == CORES
    assert json.loads(block)["parameters"]["follow_path"] == {}


def test_the_numbers_are_those_of_the_code() -> None:
    usual = Settings()
    assert states(f"within {100 * TOLERANCE:g} cm")
    assert states(f"has not taken it within {usual.patience:g} s, three times in all") and TRIES == 3
    assert states(f"more than {usual.off_route:g} m off its edge in two states")
    assert states(f"one whose connection is broken leaves after {LEAVE_AFTER:g} s")
    assert states(f"goes on to its goal within {usual.offline_patience:g} s") and usual.offline_patience == LINGER
    assert states(f"(manufacturer `{OWN_MANUFACTURER}`)")
    assert states(", ".join(f"`{kind}`" for kind in FORWARDED))
