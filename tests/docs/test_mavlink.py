"""Commands, options, numbers and names in mavlink.md are those of the code."""

import argparse
import re

import pytest

from robots.bridges.cli import mavlink as command
from robots.bridges.mavlink.bridge import CLOUD_SILENT, LEAVE_AFTER
from robots.bridges.mavlink.link import VehicleAddress
from robots.bridges.mavlink.modes import ARDUPILOT, PX4
from robots.bridges.mavlink.place import SILENT
from robots.bridges.mavlink.rover import LOST_AFTER, RATES
from robots.bridges.mavlink.vehicle import Vehicle
from robots.bridges.mavlink.velocity import LINGER, SILENCE
from robots.client.robot_file import parse_robot_file
from robots.sim.mavlink.__main__ import arguments_of
from robots.sim.mavlink.body import RoverBody
from robots.sim.mavlink.rover import GUIDED_TIMEOUT, OFFBOARD_TIMEOUT, SimulatedRover
from tests.support.documents import blocks, table, text_of

PAGE = "docs/mavlink.md"
COMMON = {"--help", "--url", "--token", "--ca-file"}


@pytest.fixture(scope="module")
def parser() -> argparse.ArgumentParser:
    made = argparse.ArgumentParser()
    command.configure(made)
    return made


def states(words: str) -> bool:
    return words in re.sub(r"\s+", " ", text_of(PAGE))


def lines(beginning: str) -> list[str]:
    return [line for line in text_of(PAGE).splitlines() if line.startswith(beginning)]


def test_the_options_are_those_of_the_command(parser: argparse.ArgumentParser) -> None:
    listed = {re.split(r"[ =]", option.strip("`"))[0] for option, _ in table(PAGE, "option", "meaning")}
    assert listed == {action.option_strings[-1] for action in parser._actions} - COMMON
    assert states(f"as a ground station ({command.STATION})")


def test_the_commands_of_the_page_are_some(parser: argparse.ArgumentParser) -> None:
    (bridge,) = lines("ppaas bridge mavlink")
    given = parser.parse_args(bridge.split()[3:])
    options = command.options_of(given)
    assert options.arm and options.anchor is not None and options.anchor.latitude == 47.3977
    (simulated,) = lines("python -m robots.sim.mavlink")
    rover = arguments_of(simulated.split()[3:])
    x, y = options.anchor.to_map(rover.latitude, rover.longitude)
    assert (x, y) == pytest.approx((2.0, 2.0), abs=0.01)


def test_the_addresses_of_the_page_are_some() -> None:
    found = re.findall(r"`(?:--vehicle )?((?:udpin|udpout|tcp):[\w.]+:\d+|/dev/tty[\w,]+)`", text_of(PAGE))
    assert {VehicleAddress.parse(text).kind for text in found} == {"udpin", "tcp", "serial"}


def test_the_lines_that_the_simulated_rover_takes_are_some() -> None:
    (taken,) = re.findall(r"takes lines such as (.*?):", re.sub(r"\s+", " ", text_of(PAGE)))
    rover = SimulatedRover("ardupilot", RoverBody(47.0, 8.0))
    for order in re.findall(r"`([^`]+)`", taken):
        rover.order(order)
    assert rover.mode.name == "HOLD" and not rover.armed and rover.fix == 1


def test_the_files_of_the_page_are_some() -> None:
    waypoints, velocities = (parse_robot_file(block).parameters for block in blocks(PAGE, "json"))
    assert waypoints["follow_path"] == {}
    assert "follow_path" not in velocities and velocities["amcl"] == {"localize": False}


def test_the_numbers_and_names_are_those_of_the_code() -> None:
    assert states(f"If none comes for {SILENCE:g} s the vehicle gets zero, and after {LINGER:g} s it is given back")
    assert states(f"no heartbeat for {SILENT:g} s | ends the goal; after {LEAVE_AFTER:g} s the robot leaves the cloud")
    assert states(f"a mission is ended after {LOST_AFTER:g} s")
    assert states(f"velocities end after {SILENCE:g} s; a mission is ended after {CLOUD_SILENT:g} s")
    assert states(f"{GUIDED_TIMEOUT:g} s (GUIDED), {OFFBOARD_TIMEOUT:g} s (OFFBOARD)")
    modes = (PX4.velocity, PX4.mission, PX4.hold)
    assert [PX4.name_of(mode) for mode in modes] == ["OFFBOARD", "AUTO.MISSION", "AUTO.LOITER"]
    assert [ARDUPILOT.name_of(mode) for mode in (ARDUPILOT.velocity, ARDUPILOT.mission, ARDUPILOT.hold)] == [
        "GUIDED", "AUTO", "HOLD",
    ]  # fmt: skip
    heard = set(re.findall(r"`([A-Z]+(?:_[A-Z]+)+)`", text_of(PAGE))) & Vehicle._TAKERS.keys()
    assert {"GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "BATTERY_STATUS", "SYS_STATUS"} <= heard
    assert max(RATES.values()) == 10.0
