"""Local nodes over real sockets and processes: their homes, and their return to the cloud after a kill."""

import asyncio
import os
import signal
import subprocess
import sys

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages import ppaas_msgs
from ppaas.messages.base.message import Empty
from ppaas.messages.base.rosapi import ServiceNode, ServiceNodeResponse, ServiceRequest
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav_msgs import GetPlan, GetPlanRequest, GetPlanResponse
from robots import cli
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import driving
from tests.support.cloud.local_nodes import ABLE, WEAK, managing
from tests.support.network.slow_link import SlowLink
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

BAD_LINK = 150e3
CLIENTS = "/rosbridge_websocket"


async def homes(client: RobotClient) -> dict[str, str]:
    """Return the home of each node."""
    answer = await client.call("node_monitor/list_nodes", ppaas_msgs.ListNodes, Empty())
    assert isinstance(answer, ppaas_msgs.NodeHomes)
    return {node.node: node.home for node in answer.nodes}


async def planned_by(client: RobotClient, start: Pose2D, goal: Pose2D) -> str:
    """Call Move Base in either home; return the node that provides the service according to rosapi."""
    there, back = (PoseStamped(Header(frame_id="map"), Pose.of(pose)) for pose in (start, goal))
    answer = await client.call("move_base/make_plan", GetPlan, GetPlanRequest(there, back), 30.0)
    assert isinstance(answer, GetPlanResponse) and answer.plan.poses
    node = await client.call("rosapi/service_node", ServiceNode, ServiceRequest("/move_base/make_plan"))
    assert isinstance(node, ServiceNodeResponse)
    return node.node


async def shown_by_rest_and_command(rest: RestClient, url: str, token: str, robot: str) -> None:
    """Assert that REST and the command line show Move Base on the robot, and the reason."""
    shown = {node["node"]: node for node in await rest.items(f"/v1/robots/{robot}/nodes")}
    assert (shown["move_base"]["home"], shown["amcl"]["home"]) == ("robot", "cloud")
    command = [sys.executable, "-m", cli.__name__, "robot", "nodes", robot, "--url", url, "--token", token]
    listing = await asyncio.to_thread(subprocess.run, command, capture_output=True, text=True, timeout=60, check=True)
    [line] = [line for line in listing.stdout.splitlines() if line.startswith("move_base")]
    assert line.split()[1:3] == ["robot", "robot"]
    assert "of a link with" in line


async def test_nodes_of_a_weak_robot_run_in_the_cloud(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=21)
    token = await register_robot(rest, "pi", "office", start)
    async with (
        RobotClient(cloud.url, robot="pi", token=token) as client,
        managing(client, WEAK) as manager,
    ):
        answer = await manager.ask("move_base")
        assert (answer.home, answer.wanted) == ("cloud", "cloud")
        assert "the robot is weak" in answer.reasons[0]
        assert set((await homes(client)).values()) == {"cloud"}
        assert (manager.running, manager.pid) == (frozenset(), None)


async def test_move_base_of_a_robot_with_a_slow_link_runs_locally_until_killed(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=23)
    first, second = (reachable_pose(office_map, start, seed=n, at_least=1.5, at_most=2.5) for n in (24, 26))
    token = await register_robot(rest, "laptop", "office", start)
    async with SlowLink(cloud.url, BAD_LINK) as link, driving(link.url, token, "laptop", office_map, start) as drive:
        async with managing(drive.robot, ABLE) as manager:
            answer = await manager.ask("move_base")
            assert answer.wanted == "robot", answer.reasons
            assert any("of a link with" in reason for reason in answer.reasons)
            await until(lambda: manager.running == {"move_base"}, 60)
            await shown_by_rest_and_command(rest, cloud.url, token, "laptop")
            assert await planned_by(drive.operator, start, first) == CLIENTS
            driven = len(drive.commands)
            await drive.send(first, "first")
            await until(lambda: len(drive.commands) > driven + 5, 30)
            assert manager.pid is not None
            os.kill(manager.pid, signal.SIGKILL)
            result = await drive.result()
            assert (result.status.goal_id.id, result.status.status) == ("first", 3)
            assert drive.scorer.error(0, first) <= 0.25, "it continued from its state in the cloud"
            assert (await homes(drive.operator))["move_base"] == "cloud"
            assert await planned_by(drive.operator, first, second) == "/move_base"
            back = await manager.ask("move_base", "robot")
            assert back.wanted == "robot"
            assert await drive.go(second) <= 0.25, "the goal is sent while the node moves"
            assert manager.running == {"move_base"}
            assert (await homes(drive.operator))["move_base"] == "robot"
            assert await planned_by(drive.operator, second, first) == CLIENTS
        assert (await homes(drive.operator))["move_base"] == "cloud", "a robot that leaves returns its nodes"
        assert drive.scorer.collisions(0) == 0
