"""SIGKILL of the cloud while a robot is in a lift: the next process leads it on to its floor."""

import os
import signal
from pathlib import Path

import pytest

from tests.support.cloud.cloud import register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import GOAL, START, ended, put_building, simulated_building, simulating
from tests.support.network.wire import wire_to
from tests.support.waiting import until

pytestmark = pytest.mark.journey


async def test_a_robot_in_a_lift_arrives_although_the_cloud_is_killed(tmp_path: Path) -> None:
    options = "--adopt-within", "120", "--device-host", "127.0.0.1"
    building = simulated_building()
    async with simulating(building) as record:
        with running_cloud(tmp_path, *options) as cloud:
            rest = await cloud.admin()
            await put_building(rest, record)
            token = await register_robot(rest, "porter", "floor-1", tuple(START))
            async with (
                wire_to(cloud.url) as wire,
                driving(wire.url, token, "porter", None, START, shared=building) as drive,
            ):
                await until(lambda: len(drive.poses) > 8)
                goal = await rest.post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
                await until(lambda: building.floor_of(building.robots[0]) == "L2", 60.0)
                os.kill(cloud.pid, signal.SIGKILL)
                cloud.status = -signal.SIGKILL
                wire.cut()
                (tmp_path / "ready.json").unlink()
                with running_cloud(tmp_path, *options) as second:
                    wire.mend(second.url)
                    last = await ended(await second.admin(), "porter", goal["id"])
                    assert last["state"] == "succeeded", last
                    assert building.floor_of(building.robots[0]) == "L2"
                    assert building.robots[0].base.pose.distance_to(GOAL) < 0.35
                    assert drive.scorer.collisions(0) == 0
