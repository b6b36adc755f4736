"""A robot that is stopped while it drives, and stands whatever dies, until it is released by name."""

import asyncio
import os
import signal
from pathlib import Path

import pytest

from ppaas.errors import NotFound, NotPermitted
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.health.stops import StopRobot, StopRobotRequest, StopState
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.local_nodes import ABLE, managing, take_over
from tests.support.network.wire import wire_to
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ROBOT = "runner"
PASSWORD = "correct horse"
STANDING = 5
"""Number of velocities that must be zero for a robot to count as standing."""


@pytest.fixture
def start(office_map: GridMap) -> Pose2D:
    return free_pose(office_map, seed=30)


@pytest.fixture
def goal(office_map: GridMap, start: Pose2D) -> Pose2D:
    return reachable_pose(office_map, start, seed=40, at_least=2.0, at_most=3.0)


async def drives(drive: Drive) -> None:
    before = len(drive.commands)
    await until(lambda: any(moves(twist) for _, twist in drive.commands[before:]))


def moves(twist: Twist) -> bool:
    return twist.linear.x != 0.0 or twist.angular.z != 0.0


async def stands(drive: Drive) -> None:
    """Wait for velocities, all of which must be zero: the robot gets them, and does not only hear nothing."""
    before = len(drive.commands)
    await until(lambda: len(drive.commands) >= before + STANDING)
    assert not any(moves(twist) for _, twist in drive.commands[before:])
    wheels = drive.world.robots[0].base.wheels
    assert (wheels.linear, wheels.angular) == (0.0, 0.0)


async def container_of(rest: RestClient) -> int:
    (pid,) = [one["pid"] for one in await rest.items("/v1/containers") if one["robot"] == ROBOT and one["pid"]]
    return int(pid)


async def test_a_stop_outlives_connection_container_and_cloud_until_it_is_released_by_name(
    tmp_path: Path, office_map: GridMap, start: Pose2D, goal: Pose2D
) -> None:
    with running_cloud(tmp_path) as cloud:
        rest = await cloud.admin()
        await publish_map(rest, "office", office_map)
        token = await register_robot(rest, ROBOT, "office", start)
        async with wire_to(cloud.url) as wire, driving(wire.url, token, ROBOT, office_map, start) as drive:
            await drive.send(goal, goal_id="far")
            await drives(drive)
            answer = await rest.post(f"/v1/robots/{ROBOT}/stop", {"reason": "a pallet fell"})
            assert (answer["standing"], answer["unconfirmed"]) == ([ROBOT], [])
            await stands(drive)
            await until(lambda: drive.status.status_list[-1].text.startswith("waiting: stopped by 'admin'"))
            await drive.operator.publish("cmd_vel", Twist(Vector3(x=0.3)))
            await stands(drive)
            wire.cut()
            wire.mend()
            await stands(drive)
            pid = await container_of(rest)
            os.kill(pid, signal.SIGKILL)
            await stands(drive)
            assert await container_of(rest) != pid
    await stands_after_a_restart(tmp_path, office_map, start)


async def stands_after_a_restart(folder: Path, grid: GridMap, start: Pose2D) -> None:
    (folder / "ready.json").unlink()  # of the cloud before
    with running_cloud(folder) as cloud:
        rest = await cloud.admin()
        [robot] = await rest.items("/v1/robots")
        assert "a pallet fell" in robot["stopped"]
        async with driving(cloud.url, cloud.token or "", ROBOT, grid, start) as drive:
            await stands(drive)
            await refused_to_another_user(cloud, rest)
            await stands(drive)
            assert drive.results.empty(), "its goal waits"
            answer = await rest.post(f"/v1/robots/{ROBOT}/release", {"reason": "the aisle is free"})
            assert ([stop["by"] for stop in answer["released"]], answer["left"]) == (["admin"], [])
            await drives(drive)
            assert drive.status.status_list[-1].goal_id.id == "far", "it goes on to the goal from before the stop"
        events = await rest.items("/v1/audit")
        told = {event["action"]: event["details"] for event in events if event["outcome"] == "ok"}
        assert told["stop_robot"] == {"reason": "a pallet fell"}
        assert told["release_robot"] == {"reason": "the aisle is free", "stopped_by": ["admin"]}


async def refused_to_another_user(cloud: RunningCloud, rest: RestClient) -> None:
    """Check that one who only drives the robot does not release it, nor one whom it is not shared with."""
    for user in ("bob", "carl"):
        await rest.post("/v1/users", {"id": user, "password": PASSWORD})
    await rest.put(f"/v1/robots/{ROBOT}/shares/bob", {"role": "drive"})
    for user, error in (("bob", NotPermitted), ("carl", NotFound)):
        client = RestClient(cloud.url)
        await client.login(user, PASSWORD)
        with pytest.raises(error):
            await client.post(f"/v1/robots/admin:{ROBOT}/release", {})


async def test_a_client_stops_the_robot_by_its_socket(
    cloud: RunningCloud, office_map: GridMap, start: Pose2D, goal: Pose2D
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    token = await register_robot(rest, ROBOT, "office", start)
    states: list[StopState] = []
    async with driving(cloud.url, token, ROBOT, office_map, start) as drive:
        await drive.operator.subscribe("stop/state", StopState, states.append)
        await drive.send(goal)
        await drives(drive)
        answer = await drive.robot.call("stop/request", StopRobot, StopRobotRequest("button"))
        assert isinstance(answer, StopState) and answer.stopped
        await stands(drive)
        async with asyncio.timeout(10.0):
            while not (stops := await rest.items("/v1/stops")):
                await asyncio.sleep(0.05)
        assert [(stop["name"], stop["reason"]) for stop in stops] == [(ROBOT, "button")]
        assert states[-1].stopped
        await rest.post(f"/v1/robots/{ROBOT}/release", {})
        await drives(drive)
        assert not states[-1].stopped


async def test_a_robot_that_drives_by_itself_stands_and_stands_before_it_moves_on_another_connection(
    cloud: RunningCloud, office_map: GridMap, start: Pose2D
) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "office", office_map)
    token = await register_robot(rest, ROBOT, "office", start)
    far = reachable_pose(office_map, start, seed=40, at_least=6.0, at_most=9.0)
    async with (
        wire_to(cloud.url) as wire,
        driving(wire.url, token, ROBOT, office_map, start) as drive,
        managing(drive.robot, ABLE) as manager,
    ):
        await take_over(manager, "amcl", "move_base")
        await drive.send(far)
        await drives(drive)
        assert await stop(rest) == ([ROBOT], [])
        await stands(drive)
        await rest.post(f"/v1/robots/{ROBOT}/release", {})
        await drives(drive)
        wire.cut()
        await until(lambda: not drive.robot.connected)
        await drives(drive)
        assert await stop(rest) == ([], [ROBOT]), "it drives by itself, and cannot be reached"
        before = drive.robot.connections
        wire.mend()
        await until(lambda: drive.robot.connections > before)
        await stands(drive)
        assert await stop(rest) == ([ROBOT], [])
        assert manager.running == {"amcl", "move_base"}
        await rest.post(f"/v1/robots/{ROBOT}/release", {})
        await drives(drive)


async def stop(rest: RestClient) -> tuple[list[str], list[str]]:
    """Stop the robot, which may be stopped already; return who stands, and of whom that is not known."""
    answer = await rest.post(f"/v1/robots/{ROBOT}/stop", {})
    return answer["standing"], answer["unconfirmed"]
