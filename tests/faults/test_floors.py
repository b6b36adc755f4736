"""Faults while a robot is in a lift: the cloud is killed, or there is no radio. It arrives on its floor afterwards."""

import asyncio
import os
import signal
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from tests.support.cloud.cloud import register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import BETWEEN, GOAL, GROUND, LOFT, START, carried, ended, put_building, world_of
from tests.support.network.wire import wire_to
from tests.support.waiting import until

pytestmark = pytest.mark.journey


async def test_a_robot_in_a_lift_arrives_although_the_cloud_is_killed(tmp_path: Path) -> None:
    with running_cloud(tmp_path, "--adopt-within", "120") as cloud:
        clients = [await cloud.admin()]
        await put_building(clients[0])
        token = await register_robot(clients[0], "porter", "floor-1", tuple(START))
        async with (
            wire_to(cloud.url) as wire,
            driving(wire.url, token, "porter", world_of(GROUND, LOFT), START) as drive,
            carried(clients, drive, "porter") as maps,
        ):
            await until(lambda: len(drive.poses) > 8)
            goal = await clients[0].post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
            await until(lambda: len(maps) > 1, 60.0)
            os.kill(cloud.pid, signal.SIGKILL)
            cloud.status = -signal.SIGKILL
            wire.cut()
            (tmp_path / "ready.json").unlink()
            with running_cloud(tmp_path, "--adopt-within", "120") as second:
                wire.mend(second.url)
                clients.append(await second.admin())
                last = await ended(clients[-1], "porter", goal)
                assert last["state"] == "succeeded", last
                assert drive.world.robots[0].base.pose.distance_to(Pose2D(GOAL.x + BETWEEN, GOAL.y)) < 0.35


async def test_a_robot_without_radio_in_a_lift_stands_and_goes_on_when_it_is_heard_again(tmp_path: Path) -> None:
    with running_cloud(tmp_path, "--linger", "3") as cloud:
        rest = await cloud.admin()
        await put_building(rest)
        token = await register_robot(rest, "porter", "floor-1", tuple(START))
        async with (
            wire_to(cloud.url) as wire,
            driving(wire.url, token, "porter", world_of(GROUND, LOFT), START) as drive,
            carried([rest], drive, "porter") as maps,
        ):
            await until(lambda: len(drive.poses) > 8)
            goal = await rest.post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
            await until(lambda: len(maps) > 1, 60.0)
            wire.cut()
            await asyncio.sleep(2.0)
            there = drive.world.robots[0].base.pose
            await asyncio.sleep(6.0)  # longer than a session lingers
            assert drive.world.robots[0].base.pose.distance_to(there) < 0.01, "no command is obeyed for long"
            assert (await rest.get(f"/v1/robots/porter/goals/{goal['id']}"))["state"] == "active"
            wire.mend()
            last = await ended(rest, "porter", goal)
            assert last["state"] == "succeeded", last
            assert drive.world.robots[0].base.pose.distance_to(Pose2D(GOAL.x + BETWEEN, GOAL.y)) < 0.35
            assert drive.scorer.collisions(0) == 0
