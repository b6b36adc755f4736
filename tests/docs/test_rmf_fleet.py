"""The commands, options, topics and numbers of rmf-fleet.md are those of the code."""

import argparse
import json
import re
import shlex

from endpoints.rest.task_schemas import TaskFile
from ppaas.tasks.options import PlaceHold
from ppaas.wire.rmf import workcells
from ppaas.wire.rmf.fleet_robot import LONGEST_WAIT, RmfMode
from ppaas.wire.ros.rmf_definitions import FLEET_STATE
from robots.bridges.cli import free_fleet, rmf
from robots.bridges.free_fleet.robot import BATTERY, BATTERY_PERIOD, NAVIGATE, POSE_PERIOD, TF
from robots.bridges.rmf.fleet import LOOK_PERIOD, REQUESTS, STATES
from robots.bridges.rmf.options import FleetForRmf, read_frames
from robots.bridges.rmf.robot_in_cloud import POSE_AGE
from tests.support.documents import blocks, table, text_of

PAGE = "docs/rmf-fleet.md"
TEXT = re.sub(r"\s+", " ", text_of(PAGE))


def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser()
    rmf.configure(made)
    return made


def test_the_commands_are_accepted() -> None:
    commands = [line for block in blocks(PAGE, "sh") for line in block.splitlines() if line.startswith("ppaas bridge")]
    driver, navigators = (shlex.split(line)[2:] for line in commands)
    arguments = parser().parse_args(driver[1:])
    assert (driver[0], arguments.robots, arguments.fleet) == ("rmf", ["tb1"], "carts")
    assert arguments.level == [("office", "L1")]
    made = argparse.ArgumentParser()
    free_fleet.configure(made)
    arguments = made.parse_args(navigators[1:])
    assert (navigators[0], arguments.name, arguments.connect) == (
        "free-fleet",
        [("tb1", "nav2_tb3")],
        ["tcp/ROUTER:7447"],
    )


def test_the_options_are_those_of_the_command() -> None:
    known = {option for action in parser()._actions for option in action.option_strings}
    shown = {option for row in table(PAGE, "option", "meaning") for option in re.findall(r"--[a-z-]+", row[0])}
    assert shown <= known
    others = {
        "-h",
        "--help",
        "--url",
        "--token",
        "--ca-file",
        "--listen",
        "--connect",
        "--zenoh-config",
        "--dds-config",
    }
    assert known - shown == others


def test_the_topics_are_those_of_the_bridge() -> None:
    shown = [(topic, kind) for topic, kind, _ in table(PAGE, "topic", "type", "")]
    taken = [(topic.lstrip("/"), kind.replace("/msg/", "/")) for topic, (kind, _) in REQUESTS.items()]
    assert shown[0] == (STATES.lstrip("/"), FLEET_STATE.replace("/msg/", "/"))
    assert sorted(shown[1:]) == sorted(taken)


def test_the_numbers_are_those_of_the_code() -> None:
    assert f"time between two states ({FleetForRmf('f').period:g} s)" in TEXT
    assert f"published within {LOOK_PERIOD:g} s" in TEXT
    assert f"More than {rmf.WORST:g} m is refused" in TEXT
    assert f"from {POSE_AGE:g} s after its last pose" in TEXT
    assert LONGEST_WAIT == 3600.0 and "more than an hour ahead" in TEXT
    modes = re.findall(r"(\w+)`? \((\d)\)", TEXT[TEXT.index("**Mode.**") : TEXT.index("**Battery.**")])
    names = {"MODE_ADAPTER_ERROR": "ADAPTER_ERROR"}
    assert {(names.get(name, name.upper()), int(number)) for name, number in modes} == {
        (mode.name, mode.value) for mode in RmfMode if mode is not RmfMode.EMERGENCY
    }


def test_the_example_of_reference_points_fits() -> None:
    example = blocks(PAGE, "yaml")[0]
    assert 0.0 < read_frames(example.encode())["L1"].residual < rmf.WORST


def test_the_keys_of_free_fleet_are_those_of_the_bridge() -> None:
    shown = {key.partition("/")[2]: kind for key, kind, _ in table(PAGE, "key of Zenoh", "type", "")}
    plain = {kind: "/".join(kind.split("/")[::2]) for kind in (TF, BATTERY, NAVIGATE)}
    assert shown == {"tf": plain[TF], "battery_state": plain[BATTERY], "navigate_to_pose/_action/…": plain[NAVIGATE]}
    assert (POSE_PERIOD, BATTERY_PERIOD) == (0.2, 1.0), "five times a second, and once"
    assert "five times a second" in TEXT and "once a second" in TEXT


def test_times_of_workcells_are_those_of_the_code() -> None:
    assert f"repeated every {workcells.REPEAT:g} s" in TEXT
    assert f"asked again after {workcells.AGAIN:g} s" in TEXT
    [example] = [json.loads(block) for block in blocks(PAGE, "json") if "dispenser" in block]
    assert TaskFile(**example).task("t", 0.0).holds[1] == PlaceHold(ingestor="rack-2")
