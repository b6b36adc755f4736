"""Robots that lose their connection during a drive, and resume it."""

import asyncio
import os
import signal
from pathlib import Path

import pytest

from ppaas.maps.grid import GridMap
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.geometry_msgs import PoseWithCovarianceStamped
from robots.client.connection import ConnectionOptions
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.sim.robot import SimulatedRobot, SimulatedRobotModel
from robots.sim.world import World
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.network.wire import Wire, wire_to
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

AWAY = 5.0
"""Time without a connection [s]: longer than the base controller's timeout, shorter than the linger."""


async def arrives_once(drive: Drive, goal_id: str) -> None:
    result = await drive.result()
    assert (result.status.goal_id.id, result.status.status) == (goal_id, Status.SUCCEEDED), result.status.text
    assert drive.results.empty(), "one result a goal"


async def drives(drive: Drive, since: int | None = None) -> None:
    """Wait until the robot has received some commands after the first ``since``, by default those until now."""
    before = len(drive.commands) if since is None else since
    await until(lambda: len(drive.commands) > before + 5)


async def stands_still(drive: Drive) -> None:
    base = drive.world.robots[0].base
    await until(lambda: base.wheels.linear == base.wheels.angular == 0.0)


async def away(drive: Drive, wire: Wire) -> int:
    """Cut the wire for `AWAY` seconds; the robot stops by itself. Return the number of commands so far."""
    loop = asyncio.get_running_loop()
    wire.cut()
    mended = loop.time() + AWAY
    await stands_still(drive)
    await asyncio.sleep(mended - loop.time())
    wire.mend()
    return len(drive.commands)


async def container_of(cloud: RunningCloud, robot: str) -> int:
    rest = await cloud.admin()
    (pid,) = [container["pid"] for container in await rest.items("/v1/containers") if container["robot"] == robot]
    return int(pid)


async def test_a_robot_away_for_5_s_resumes_session_subscriptions_and_goal(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=30)
    goal = reachable_pose(office_map, start, seed=40, at_least=6.0, at_most=8.0)
    token = await register_robot(rest, "traveller", "office", start)
    async with wire_to(cloud.url) as wire, driving(wire.url, token, "traveller", office_map, start) as drive:
        await drive.send(goal, goal_id="far")
        clients = drive.robot, drive.operator
        for times, container_dies in enumerate((False, True), start=1):
            await drives(drive)
            pid = await container_of(cloud, "traveller")
            if container_dies:
                os.kill(pid, signal.SIGKILL)
            stopped = await away(drive, wire)
            # Either client may be back first, by seconds, and the robot may arrive before the operator is.
            await drives(drive, stopped)
            await until(lambda n=times: [(c.connections, c.resumptions) for c in clients] == [(n + 1, n)] * 2)
            assert (await container_of(cloud, "traveller") != pid) is container_dies
        await arrives_once(drive, "far")
        assert drive.scorer.error(0, goal) <= 0.25


async def test_a_robot_with_a_silent_link_takes_over_its_own_place(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=31)
    goal = reachable_pose(office_map, start, seed=41, at_least=2.0, at_most=3.0)
    token = await register_robot(rest, "silent", "office", start)
    async with (
        wire_to(cloud.url) as wire,
        driving(
            wire.url, token, "silent", office_map, start, link=ConnectionOptions(ping_interval=1.0, ping_timeout=2.0)
        ) as drive,
    ):
        await drive.send(goal, goal_id="far")
        await drives(drive)
        wire.fall_silent()
        await stands_still(drive)
        await arrives_once(drive, "far")
        for client in (drive.robot, drive.operator):  # the cloud still trusted their old connection
            assert client.resumptions == client.connections - 1 > 0


async def test_an_idle_robot_is_disconnected_until_it_publishes(tmp_path: Path, office_map: GridMap) -> None:
    start = free_pose(office_map, seed=32)
    with running_cloud(tmp_path, "--idle", "1") as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        token = await register_robot(rest, "idler", "office", start)
        await reconnects_to_publish(
            cloud, rest, token, World(office_map, seed=0).add_robot(start, SimulatedRobotModel())
        )


async def reconnects_to_publish(cloud: RunningCloud, rest: RestClient, token: str, simulated: SimulatedRobot) -> None:
    poses: list[PoseWithCovarianceStamped] = []
    async with RobotClient(cloud.url, robot="idler", token=token) as robot:
        await robot.subscribe("amcl_pose", PoseWithCovarianceStamped, poses.append)
        await until(lambda: not robot.connected)
        containers = await rest.items("/v1/containers")
        assert "idler" not in [container["robot"] for container in containers]
        [machine] = await rest.items("/v1/machines")
        assert machine["containers"] == len(containers)
        await robot.publish("odom", simulated.odometry())
        await robot.publish("scan", simulated.scan())
        await until(lambda: poses)
        assert robot.connections == 2
