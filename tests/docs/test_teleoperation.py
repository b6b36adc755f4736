"""The page about driving by hand: its parameters, its frame, and the program, which drives a robot in a real cloud."""

import asyncio
import json
import os
import sys
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.codec import decode
from ppaas.messages.operators.teleoperation import TeleopCommand
from ppaas.navigation.teleoperation import TeleopParameters
from ppaas.plugins import parameters_in_use
from robots.client.rest import RestClient
from tests.support.cloud.cloud import ADMIN_PASSWORD, RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.documents import ADDRESS, blocks, table
from tests.support.sources import ROOT
from tests.support.waiting import patience, until
from tests.support.world.planar_world import walled_map

PAGE = "docs/teleoperation.md"


def test_parameters_and_defaults_are_those_of_the_code() -> None:
    listed = {name: float(value) for name, value, _ in table(PAGE, "parameter of `teleop`", "default", "meaning")}
    assert listed == parameters_in_use(TeleopParameters())


def test_the_frame_is_a_command() -> None:
    [frame] = map(json.loads, blocks(PAGE, "json"))
    command = decode(TeleopCommand, json.dumps(frame["msg"]).encode())
    assert (frame["topic"], command.linear, command.enable) == ("/teleop_cmd", 0.2, True)


@pytest.mark.journey
async def test_the_program_drives_a_robot(cloud: RunningCloud, tmp_path: Path) -> None:
    room, start = walled_map(6.0, 4.0, []), Pose2D(1.5, 2.0, 0.0)
    admin, rest = await cloud.admin(), RestClient(cloud.url)
    await admin.post("/v1/users", {"id": "theo", "password": ADMIN_PASSWORD})
    await rest.login("theo", ADMIN_PASSWORD)
    await publish_map(rest, "theo-room", room)
    token = await register_robot(rest, "tb1", "theo-room", start)
    [program] = blocks(PAGE, "python")
    script = tmp_path / "drive.py"
    script.write_text(program.replace(ADDRESS, cloud.url))
    async with driving(cloud.url, token, "tb1", room, start) as drive:
        await until(lambda: drive.poses)
        environment = os.environ | {"PPAAS_TOKEN": token, "PYTHONPATH": str(ROOT)}
        running = await asyncio.create_subprocess_exec(sys.executable, str(script), env=environment)
        async with patience(60.0):
            assert await running.wait() == 0
        await until(lambda: drive.commands[-1][1].linear.x == 0.0)
        assert drive.world.robots[0].base.pose.x > start.x + 0.2
