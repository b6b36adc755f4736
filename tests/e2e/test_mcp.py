"""A robot is looked at and driven by the MCP client of the library, and of the release before it."""

import asyncio
import json
import os
import sys
from pathlib import Path
from typing import Any

import pytest
from mcp import Client, StdioServerParameters
from mcp.client.stdio import stdio_client

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from robots import cli
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.sources import ROOT
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

OLDER = ROOT / "build" / "clients" / "mcp-1"
SCRIPT = ROOT / "tests" / "support" / "clients" / "mcp_1.py"


@pytest.fixture
def start(office_map: GridMap) -> Pose2D:
    return free_pose(office_map, seed=50)


@pytest.fixture
def goal(office_map: GridMap, start: Pose2D) -> Pose2D:
    return reachable_pose(office_map, start, seed=51, at_least=0.6, at_most=1.2)


async def token_for(rest: RestClient, robot: str, role: str) -> str:
    made = await rest.post("/v1/scoped-tokens", {"robots": [robot], "role": role})
    return str(made["token"])


def server(cloud: RunningCloud, token: str, *options: str) -> StdioServerParameters:
    env = {"PPAAS_URL": cloud.url, "PPAAS_TOKEN": token, "PYTHONPATH": os.pathsep.join(sys.path)}
    return StdioServerParameters(command=sys.executable, args=["-m", cli.__name__, "mcp", *options], env=env)


async def test_a_robot_is_looked_at_and_driven(
    cloud: RunningCloud, office_map: GridMap, start: Pose2D, goal: Pose2D
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    robot_token = await register_robot(rest, "mcp1", "office", start)
    heard: list[str] = []

    async def progressed(_done: float, _total: float | None, message: str | None) -> None:
        heard.append(message or "")

    async with (
        driving(cloud.url, robot_token, "mcp1", office_map, start) as drive,
        Client(stdio_client(server(cloud, await token_for(rest, "mcp1", "drive")))) as client,
    ):

        async def call(tool: str, **arguments: Any) -> Any:
            return await client.call_tool(tool, {"robot": "mcp1"} | arguments, progress_callback=progressed)

        planned = (await call("plan_path", x=goal.x, y=goal.y)).structured_content
        assert planned["poses"][0][:2] == pytest.approx(start[:2], abs=0.3)
        assert planned["poses"][-1][:2] == pytest.approx(goal[:2], abs=0.1)
        assert planned["length"] >= 0.5 and len(planned["poses"]) <= 100
        picture = await client.call_tool("map_picture", {"map": "office"})
        assert "mcp1 at x" in picture.content[0].text  # type: ignore[union-attr]
        reached = (await call("go_to", x=goal.x, y=goal.y, yaw=goal.theta, wait=120.0)).structured_content
        assert reached["state"] == "succeeded"
        assert drive.scorer.error(0, goal) < 0.3
        assert any(message.startswith("active, at x") for message in heard)
        outside = (await call("go_to", x=-50.0, y=0.0, wait=60.0)).structured_content
        assert outside["state"] in ("aborted", "rejected") and outside["text"]
        wall = await call("plan_path", x=-50.0, y=0.0)
        assert wall.is_error


@pytest.mark.clients
async def test_the_release_before_drives_too(
    cloud: RunningCloud, office_map: GridMap, start: Pose2D, goal: Pose2D, tmp_path: Path
) -> None:
    if not OLDER.is_dir():
        pytest.skip("mcp 1.30 is not installed: run make test-clients")
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    robot_token = await register_robot(rest, "mcp2", "office", start)
    started = server(cloud, await token_for(rest, "mcp2", "drive"))
    order = {"server": started.model_dump(), "robot": "mcp2", "goal": [goal.x, goal.y]}
    async with driving(cloud.url, robot_token, "mcp2", office_map, start):
        process = await asyncio.create_subprocess_exec(
            sys.executable, str(SCRIPT), json.dumps(order), stdout=asyncio.subprocess.PIPE,
            env=os.environ | {"PYTHONPATH": str(OLDER)},
        )  # fmt: skip
        printed, _ = await asyncio.wait_for(process.communicate(), 150.0)
    found = json.loads(printed)
    assert (found["library"], found["protocol"]) == ("1.30.0", "2025-11-25")
    assert "go_to" in found["tools"]
    assert found["picture"] == "image/png"
    assert found["refused"].startswith("not-permitted: ")
    assert found["unknown"].startswith("invalid-input: ")
    assert found["goal"]["state"] == "succeeded"
    assert found["progress"] > 1
