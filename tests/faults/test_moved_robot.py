"""SIGKILL of a machine and of the cloud while a robot is moved to another map: it goes on there, in its session."""

import os
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.network.wire import Wire, wire_to
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

GROUND = walled_map(6.6, 4.5, [(4.3, 1.1, 4.5, 3.4), (1.0, 3.0, 1.6, 3.4)])
SHIFT = Pose2D(10.0, -3.0, 0.0)
UPPER = GridMap(GROUND.data, GridInfo(GROUND.info.resolution, GROUND.info.width, GROUND.info.height, SHIFT))
START = Pose2D(0.6, 0.8, 0.0)


@asynccontextmanager
async def standing(cloud: RunningCloud, rest: RestClient) -> AsyncIterator[tuple[Drive, Wire]]:
    """Connect a robot that stands on the lower map, over a wire that can be cut."""
    await publish_map(rest, "ground", GROUND)
    await publish_map(rest, "upper", UPPER)
    token = await register_robot(rest, "rider", "ground", tuple(START))
    async with wire_to(cloud.url) as wire, driving(wire.url, token, "rider", GROUND, START) as drive:
        await until(lambda: len(drive.poses) > 8)  # the clone has stored a checkpoint by then
        yield drive, wire


async def move(rest: RestClient, drive: Drive) -> None:
    """Report that the robot is on the upper map."""
    await rest.post("/v1/robots/rider/move", {"map": "upper", "pose": list(SHIFT @ drive.world.robots[0].base.pose)})


async def assert_upstairs(drive: Drive, rest: RestClient) -> None:
    """Assert that the robot is localized on the upper map, and drives there."""
    await until(lambda: drive.estimate().distance_to(SHIFT @ drive.world.robots[0].base.pose) < 0.15, 30.0)
    [container] = [one for one in await rest.items("/v1/containers") if one["robot"] == "rider"]
    assert container["map"]["id"] == "upper"
    goal = Pose2D(1.6, 0.8, 0.0)
    await drive.go(SHIFT @ goal)
    assert drive.scorer.error(0, goal) <= 0.3


def assert_one_session(drive: Drive) -> None:
    """Assert that the sessions of robot and operator outlived the move."""
    for client in (drive.robot, drive.operator):
        assert client.resumptions == client.connections - 1


async def test_the_machine_is_killed_while_the_robot_is_moved(tmp_path: Path) -> None:
    with running_cloud(tmp_path) as cloud:
        rest = await cloud.admin()
        async with standing(cloud, rest) as (drive, _):
            agent = cloud.agent()
            await move(rest, drive)
            agent.kill()
            await assert_upstairs(drive, rest)
            assert_one_session(drive)


@pytest.mark.parametrize("moved_first", [True, False], ids=["after the order", "before the order"])
async def test_the_cloud_is_killed_while_the_robot_is_moved(tmp_path: Path, moved_first: bool) -> None:
    with running_cloud(tmp_path, "--adopt-within", "120") as cloud:
        rest = await cloud.admin()
        async with standing(cloud, rest) as (drive, wire):
            if moved_first:
                await move(rest, drive)
            else:  # as if it was killed between the change of the file and the order
                there = {"map": "upper", "initial_pose": list(SHIFT @ drive.world.robots[0].base.pose)}
                await rest.patch("/v1/robots/rider", there)
            os.kill(cloud.pid, signal.SIGKILL)
            cloud.status = -signal.SIGKILL
            wire.cut()
            (tmp_path / "ready.json").unlink()
            with running_cloud(tmp_path, "--adopt-within", "120") as second:
                wire.mend(second.url)
                await assert_upstairs(drive, await second.admin())
                if moved_first:  # else the container leaves while its clients resume
                    assert_one_session(drive)
