"""An unmodified roslibpy is an operator of the cloud."""

import asyncio
import sys
from pathlib import Path

import pytest

from ppaas.maps.grid import GridMap
from tests.support.cloud import RunningCloud, publish_map, register_robot
from tests.support.drive import driving
from tests.support.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

SCRIPT = Path(__file__).parents[2] / "docs" / "examples" / "roslibpy_operator.py"


async def test_a_roslibpy_script_sees_the_robot_and_sends_it_somewhere(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=10)
    goal = reachable_pose(office_map, start, seed=11, at_least=3.0)
    token = await register_robot(rest, "tb-roslib", "office", start)
    url = f"{cloud.ws_url}/?robot=tb-roslib&role=operator&token={token}"
    async with driving(cloud.url, token, "tb-roslib", office_map, start) as drive:
        script = await asyncio.create_subprocess_exec(
            sys.executable, str(SCRIPT), url, str(goal.x), str(goal.y),
            stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.STDOUT,
        )  # fmt: skip
        output, _ = await script.communicate()
        assert script.returncode == 0, output.decode()
        assert drive.scorer.error(0, goal) <= 0.25
    assert "['/cmd_vel', '/map', '/scan', '/tf']" in output.decode()
