"""lifts.md: its commands are typed, and its schemes, members, registers and numbers are those of the code."""

import argparse
import asyncio
import json
import re
import shlex

import pytest

from endpoints.cli import device
from engine.control.buildings import held_device
from engine.control.fleet_events import BUILDING_EVENTS
from engine.control.journeys import open_sites
from engine.devices import base, http_json, modbus
from engine.devices.json_states import door_order, lift_order, lift_state_of
from engine.devices.opening import DEVICES
from ppaas.buildings import faults
from ppaas.buildings.doors import controller as doors
from ppaas.buildings.doors.states import DOOR_MODES, DoorRequest
from ppaas.buildings.lifts import attendant, car, schedule, simulated
from ppaas.buildings.lifts.states import MODES, EndSession, LiftRequest, LiftState
from tests.support.documents import blocks, script, table, text_of

PAGE = "docs/lifts.md"


def page() -> str:
    return re.sub(r"\s+", " ", text_of(PAGE))


async def test_the_commands_are_typed(capsys: pytest.CaptureFixture[str]) -> None:
    commands = [shlex.split(line)[1:] for line in script(PAGE).splitlines()]
    assert [command[:2] for command in commands] == [["device", "try"]] * 2
    parser = argparse.ArgumentParser()
    device.configure(parser)
    runs = (asyncio.to_thread(device.run, parser.parse_args(command[1:])) for command in commands)
    assert await asyncio.gather(*runs) == [0, 0]
    shown = capsys.readouterr().out
    assert "floor=L2  door=open" in shown and "mode=open" in shown


def test_all_schemes_are_listed_with_their_extras() -> None:
    rows = table(PAGE, "URL", "what it reaches", "options", "extra")
    listed = {scheme: row[3] or None for row in rows for scheme in re.findall(r"(?:^|`)(\w+):", row[0])}
    assert listed == {name: DEVICES.load(name).extra for name in DEVICES.names()}


def test_members_and_orders_are_those_of_the_code() -> None:
    rows = {row[0].strip("`"): row[1] for row in table(PAGE, "state of a lift", "values")}
    assert set(rows) == set(LiftState.__struct_fields__) - {"lift"}
    assert set(re.findall(r"`(\w+)`", rows["mode"])) == set(MODES)
    [example] = blocks(PAGE, "json")
    url = base.DeviceUrl.parse("http://h/")
    assert lift_state_of(example.encode(), "A", url).session == "ppaas/hotel/A"
    orders = [json.loads(row[1].strip("`")) for row in table(PAGE, "order", "JSON")]
    assert orders == [
        lift_order(LiftRequest("A", "ppaas/hotel/A", "L2"), url),
        lift_order(EndSession("A", "ppaas/hotel/A"), url),
        door_order(DoorRequest("L1", "main", "ppaas/hotel/L1/main", "open")),
        door_order(DoorRequest("L1", "main", "ppaas/hotel/L1/main", "closed")),
    ]


def test_registers_have_the_numbers_of_the_code() -> None:
    lift = {row[0]: row[1] for row in table(PAGE, "lift, register", "input", "holding")}
    assert lift["base + 1"] == "doors: " + numbered(modbus.DOORS)
    assert lift["base + 2"] == numbered(modbus.MOTIONS)
    assert lift["base + 3"] == "mode: " + numbered(modbus.LIFT_MODES)
    door = table(PAGE, "door, register", "input", "holding")
    assert door[0][1] == numbered(DOOR_MODES)
    assert f"stands still for {modbus.FROZEN:g} s" in page()


def numbered(names: tuple[str, ...]) -> str:
    return ", ".join(f"{number} {name}" for number, name in enumerate(names))


def test_numbers_are_those_of_the_code() -> None:
    text = page()
    assert schedule.AGED > attendant.TAKEN - 1.0 and held_device.SEND_TIMEOUT < simulated.HOLD
    for said in (
        f"if no request has come for {simulated.HOLD:g} s",
        f"after {car.SILENT:g} s without one a lift counts as silent",
        f"repeated every {http_json.POLL:g} s",
        f"Both have {http_json.TIMEOUT:g} s",
        f"after {schedule.AGED:g} s a robot is fetched before all others",
        f"open for {car.SETTLED:g} s",
        f"waits in the car for {attendant.BLOCKED:g} s",
        f"are refused after {attendant.OUT_OF_ORDER:g} s, and take another way",
        f"ended after {car.SILENT:g} s if no robot is in it",
        f"robots that wait are refused after {attendant.UNHEARD:g} s",
        f"after {attendant.NO_PROGRESS:g} s without progress, and after {attendant.PATIENCE:g} s in any case",
        f"robots wait, for up to {attendant.TAKEN:g} s",
        f"after {attendant.STRANDED:g} s robots in the car leave",
        f"people are called after {attendant.STUCK:g} s",
        f"loses its place after {attendant.GONE:g} s",
        f"given up after {attendant.NO_RADIO:g} s",
        f"refused after {doors.NO_OPENING:g} s",
        f"for {open_sites.LINGER:g} s after the last one ended",
        f"the {open_sites.MOST_IDLE} that were used last",
        f"in a fire mode for {faults.PATIENCE:g} s",
    ):
        assert said in text, said


def test_all_events_are_listed() -> None:
    listed = [name for row in table(PAGE, "event", "when") for name in re.findall(r"`([\w.]+)`", row[0])]
    assert sorted(listed) == sorted(BUILDING_EVENTS)
