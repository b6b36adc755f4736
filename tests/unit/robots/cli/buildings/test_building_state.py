"""Verb ``ppaas building state``: lifts, doors and journeys in tables, once or until Ctrl-C."""

import json

import pytest

from robots.cli.buildings.building_state import as_text
from tests.support.cloud.command_line import CommandLine
from tests.support.endpoints.fake_journeys import FakeJourneys
from tests.support.storage.records import building
from tests.unit.endpoints.rest.buildings.test_building_state import STATE

SEEN = {
    "building": 1,
    "lifts": [
        {
            "lift": "north", "fault": "", "floor": "L1", "target": "L2", "door": "closed", "motion": "up",
            "mode": "agv", "session": "ppaas/ann/inn/north",
            "rides": [
                {"robot": "tb1", "origin": "L1", "destination": "L2", "phase": "inside", "since": 100.0},
                {"robot": None, "origin": "L2", "destination": "L1", "phase": "waiting", "since": 101.0},
            ],
        }
    ],
    "doors": [{"floor": "L1", "door": "gate", "mode": "offline", "fault": "door 'gate' is offline", "robots": ["tb2"]}],
    "faults": ["lift 'south': \x1b[31mno plug-in"],
    "journeys": [
        {
            "robot": "tb1", "goal": "journey-1", "on": "L1", "floor": "L2", "phase": "inside", "leg": "north",
            "state": "active", "text": "", "since": 0.0, "ended": None,
        },
        {
            "robot": None, "goal": None, "on": "L1", "floor": "L2", "phase": "driving", "leg": "", "state": "succeeded",
            "text": "", "since": 0.0, "ended": 9.0,
        },
    ],
}  # fmt: skip


def test_the_state_is_three_tables_and_the_faults() -> None:
    lines = [line.split("  ") for line in as_text(SEEN).splitlines()]
    text = [[part.strip() for part in line if part] for line in lines]
    assert text[1] == [
        "north", "L1", "closed", "up", "agv", "L2", "tb1 inside L1-L2, (another user's) waiting L2-L1", "-",
    ]  # fmt: skip
    assert text[4] == ["gate", "L1", "offline", "tb2", "door 'gate' is offline"]
    assert text[7][:5] == ["tb1", "L1", "L2", "inside", "north"]
    assert text[8][:5] == ["(another user's)", "L1", "L2", "succeeded", "-"]
    assert text[10] == ["fault: lift 'south': \N{REPLACEMENT CHARACTER}[31mno plug-in"]


def test_a_building_without_devices_says_so() -> None:
    empty = {"building": 1, "lifts": [], "doors": [], "faults": [], "journeys": []}
    assert as_text(empty).splitlines() == [
        "no lifts with a device", "", "no doors with a device", "", "no journeys", "",
    ]  # fmt: skip


@pytest.fixture
def line(ppaas: CommandLine) -> CommandLine:
    ppaas.services.store.put_building(building("inn"))
    ppaas.services.journeys = made = FakeJourneys()
    made.state = STATE
    return ppaas


async def test_the_command_prints_tables_or_json(line: CommandLine) -> None:
    answer = await line("building", "state", "inn")
    assert answer.status == 0, answer.err
    assert "tb1 inside L1-L2" in answer.out and "fault: lift 'south': no plug-in" in answer.out
    found = json.loads((await line("building", "state", "inn", "--json")).out)
    assert [lift["lift"] for lift in found["lifts"]] == ["north"]
    assert (await line("building", "state", "motel")).status == 1
