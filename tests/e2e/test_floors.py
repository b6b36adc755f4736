"""A robot is sent to another floor over REST: it takes the lift and arrives, though its clone is killed on the way."""

import os
import signal

import pytest

from tests.support.cloud.cloud import RunningCloud, register_robot
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import GOAL, START, ended, put_building, simulated_building, simulating
from tests.support.waiting import until

pytestmark = pytest.mark.journey


async def test_a_robot_arrives_on_another_floor_although_its_clone_is_killed_in_the_lift(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    building = simulated_building()
    async with simulating(building) as record:
        await put_building(rest, record)
        token = await register_robot(rest, "porter", "floor-1", tuple(START))
        async with driving(cloud.url, token, "porter", None, START, shared=building) as drive:
            await until(lambda: bool(drive.poses))
            goal = await rest.post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
            assert goal["id"].startswith("journey-") and goal["state"] == "active"
            await until(lambda: building.floor_of(building.robots[0]) == "L2", 60.0)
            [container] = [one for one in await rest.items("/v1/containers") if one["robot"] == "porter"]
            os.kill(container["pid"] or cloud.container().pid, signal.SIGKILL)
            last = await ended(rest, "porter", goal["id"])
            assert last["state"] == "succeeded", last
            assert (await rest.get("/v1/robots/porter"))["map"] == "floor-2"
            assert building.floor_of(building.robots[0]) == "L2"
            assert building.robots[0].base.pose.distance_to(GOAL) < 0.35
            assert drive.scorer.collisions(0) == 0 and drive.robot.connections == 1
            assert (await rest.get("/v1/robots/porter/goals"))["items"][-1]["id"] == goal["id"]
