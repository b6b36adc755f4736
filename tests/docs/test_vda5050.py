"""Options, names and numbers in vda5050.md are those of the code."""

import argparse
import json
import re

import pytest

from engine.master.places import LINGER
from ppaas.wire.vda5050.agv.action_book import INSTANT_2, INSTANT_3
from ppaas.wire.vda5050.agv.agv import OWN_DEVIATION, REMEMBERED
from ppaas.wire.vda5050.agv.zone_book import SUPPORTED
from ppaas.wire.vda5050.agv.zone_grids import RESOLUTION, SPEED_STEP
from ppaas.wire.vda5050.codec import MAX_PAYLOAD
from ppaas.wire.vda5050.master.route import TOLERANCE
from ppaas.wire.vda5050.master.settings import TRIES, Settings
from ppaas.wire.vda5050.spelling import ONLY_3
from robots.bridges.agv.agv_robot import FORWARDED, LEAVE_AFTER
from robots.bridges.agv.options import MAJORS, OWN_MANUFACTURER
from robots.bridges.agv.registration import CORES
from robots.bridges.cli import agv, vda5050
from robots.bridges.vda5050.agv_bridge import MAINS
from robots.bridges.vda5050.agv_options import AgvOptions
from robots.bridges.vda5050.broker import PASSWORD
from robots.bridges.vda5050.clone_side import ACTION_TIMEOUT, POSE_AGE
from robots.bridges.vda5050.mqtt_link import KEEP_ALIVE
from robots.client.robot_file import parse_robot_file
from tests.support.documents import blocks, table, text_of

PAGE = re.sub(r"\s+", " ", text_of("docs/vda5050.md"))


def test_the_options_are_those_of_the_command() -> None:
    parser = argparse.ArgumentParser()
    vda5050.configure(parser)
    known = {option for action in parser._actions for option in action.option_strings}
    shown = set(re.findall(r"`(--[a-z-]+)", PAGE))
    assert shown <= known
    assert known - shown <= {"-h", "--help", "--url", "--token", "--ca-file"}
    assert PASSWORD in PAGE


def test_the_numbers_are_those_of_the_code() -> None:
    options = AgvOptions()
    assert f"longest time between two states ({options.state_interval:g} s)" in PAGE
    assert f"time between two visualizations ({options.visualization_interval:g} s)" in PAGE
    assert f"at least within {OWN_DEVIATION:g} m" in PAGE
    assert f"of the last {REMEMBERED}" in PAGE
    assert f"no pose has come for {POSE_AGE:g} s" in PAGE
    assert f"They have {ACTION_TIMEOUT:g} s" in PAGE
    assert f"without it {MAINS:g} %" in PAGE
    assert f"after up to {round(1.5 * KEEP_ALIVE + 0.5)} s" in PAGE
    assert f"cells of {100 * RESOLUTION:g} cm" in PAGE
    assert f"in steps of {SPEED_STEP:g} m/s up to {100 * SPEED_STEP:g} m/s" in PAGE
    assert MAX_PAYLOAD == 1 << 20 and "more than 1 MiB are refused" in PAGE


def test_the_errors_are_those_of_the_code() -> None:
    shown = re.findall(r"\| ((?:`[A-Z]+_[A-Z_]+`(?:, )?)+) \| `(\w+)` \|", PAGE)
    pairs = {name: old for names, old in shown for name in re.findall(r"`(\w+)`", names)}
    assert pairs.items() <= ONLY_3["errorType"].items()
    assert ONLY_3["errorType"].keys() - pairs.keys() == {
        "INVALID_INSTANT_ACTION", "NO_ORDER_TO_CANCEL", "LOCALIZATION_ERROR",
    }  # fmt: skip


def test_the_actions_and_zones_are_those_of_the_code() -> None:
    assert all(f"`{name}`" in PAGE for name in {*INSTANT_2, *INSTANT_3})
    assert f"zones of type `{SUPPORTED[0]}` and `{SUPPORTED[1]}`" in PAGE


AGVS_PAGE = "docs/vda5050-agvs.md"
ELSEWHERE = {"--help", "--url", "--ca-file", "--token", "--password-file", "--broker-ca-file"}
"""Options that all bridges have."""


def states(words: str) -> bool:
    return words in re.sub(r"\s+", " ", text_of(AGVS_PAGE))


@pytest.fixture(scope="module")
def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser()
    agv.configure(made)
    return made


def test_the_options_of_agvs_are_those_of_the_command(parser: argparse.ArgumentParser) -> None:
    listed = {option.strip("`").split()[0] for option, _ in table(AGVS_PAGE, "option", "meaning")}
    known = {action.option_strings[-1] for action in parser._actions if action.option_strings}
    assert listed == known - ELSEWHERE
    meanings = dict(table(AGVS_PAGE, "option", "meaning"))
    usual = Settings()
    assert f"({usual.base_length:g} m)" in meanings["--base M"]
    assert f"({usual.deviation:g} m)" in meanings["--deviation M"]
    given = parser.parse_args(["--broker", "mqtt://broker"])
    assert (given.base, given.deviation) == (usual.base_length, usual.deviation)
    assert meanings["--interface NAME"].endswith(f"`{MAJORS['v2']}` (2.x) and `{MAJORS['v3']}` (3.0)")


def test_the_command_of_the_page_is_one(parser: argparse.ArgumentParser) -> None:
    (command,) = (line for line in text_of(AGVS_PAGE).splitlines() if line.startswith("ppaas bridge agv"))
    given = parser.parse_args(command.split()[3:])
    assert given.map == [("hall-1", "office")]


def test_the_file_of_the_page_is_one() -> None:
    (block,) = blocks(AGVS_PAGE, "json")
    assert parse_robot_file(block).cores == CORES
    assert json.loads(block)["parameters"]["follow_path"] == {}


def test_the_numbers_of_agvs_are_those_of_the_code() -> None:
    usual = Settings()
    assert states(f"within {100 * TOLERANCE:g} cm")
    assert states(f"has not taken it within {usual.patience:g} s, three times in all") and TRIES == 3
    assert states(f"more than {usual.off_route:g} m off its edge in two states")
    assert states(f"one whose connection is broken leaves after {LEAVE_AFTER:g} s")
    assert states(f"goes on to its goal within {usual.offline_patience:g} s") and usual.offline_patience == LINGER
    assert states(f"(manufacturer `{OWN_MANUFACTURER}`)")
    assert states(", ".join(f"`{kind}`" for kind in FORWARDED))
