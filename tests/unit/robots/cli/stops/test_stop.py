"""Tests of ``ppaas stop`` and ``ppaas release``."""

import json

import pytest

from tests.support.cloud.command_line import CommandLine
from tests.support.storage import records


@pytest.fixture(autouse=True)
def _robots(ppaas: CommandLine) -> None:
    for robot in ("tb1", "tb2"):
        ppaas.services.store.put_robot(records.robot(robot))


async def test_a_robot_is_stopped_listed_and_released(ppaas: CommandLine) -> None:
    assert (await ppaas("stop")).out == "nothing is stopped\n"
    assert (await ppaas("stop", "tb1", "--reason", "smoke")).rows[1][:4] == ["ann", "robot", "tb1", "ann"]
    assert "smoke" in (await ppaas("stop")).out
    assert "smoke" in (await ppaas("robot", "list", "--wide")).out
    released = json.loads((await ppaas("release", "tb1", "--json")).out)
    assert [stop["reason"] for stop in released["released"]] == ["smoke"]
    assert (await ppaas("release", "tb1")).out == "nothing was stopped\n"


async def test_a_release_of_all_names_what_is_still_stopped(ppaas: CommandLine) -> None:
    await ppaas("stop", "--all")
    await ppaas("stop", "tb2")
    assert [stop["scope"] for stop in json.loads((await ppaas("stop", "--json")).out)] == ["all", "robot"]
    ended = await ppaas("release", "--all")
    assert "still stopped by:" in ended.out and "tb2" in ended.out


async def test_stops_of_others_and_of_unknown_robots_are_refused(ppaas: CommandLine) -> None:
    for arguments in (("stop", "tb9"), ("release", "tb9"), ("stop", "--map", "nowhere")):
        ended = await ppaas(*arguments)
        assert (ended.status, ended.out) == (1, "")
    assert (await ppaas("stop", "ann:tb1", user="bob")).status == 1


@pytest.mark.parametrize("arguments", [("stop", "tb1", "--all"), ("stop", "--all", "--map", "house"), ("release",)])
async def test_one_target_must_be_named(ppaas: CommandLine, arguments: tuple[str, ...]) -> None:
    ended = await ppaas(*arguments)
    assert ended.status != 0
    assert (await ppaas("stop")).out == "nothing is stopped\n"
