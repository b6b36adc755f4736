"""Faults while robots ride in a lift: their machine is killed, nobody leads the lift any more, or there is a fire."""

import os
import signal
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from robots.client.rest import RestClient
from robots.sim.floors.building import SimulatedBuilding
from tests.support.cloud.cloud import RunningCloud, register_robot, running_cloud
from tests.support.cloud.drive import Drive, driving
from tests.support.cloud.floors import GOAL, START, ended, put_building, simulated_building, simulating
from tests.support.cloud.joined_machine import JoinedMachine, container_of, ticket
from tests.support.waiting import until

pytestmark = pytest.mark.journey

OPTIONS = "--device-host", "127.0.0.1"
LIFT = "north"


def floor_of_robot(building: SimulatedBuilding) -> str:
    return building.floor_of(building.robots[0])


def session(building: SimulatedBuilding) -> str:
    return building.lifts[LIFT].state(building.time()).session


@asynccontextmanager
async def travelling(rest: RestClient, url: str, building: SimulatedBuilding) -> AsyncIterator[tuple[Drive, str]]:
    """Drive a robot that was sent to the other floor; yield it with the id of its goal."""
    async with simulating(building) as record:
        await put_building(rest, record)
        token = await register_robot(rest, "porter", "floor-1", tuple(START))
        async with driving(url, token, "porter", None, START, shared=building) as drive:
            await until(lambda: len(drive.poses) > 8)
            goal = await rest.post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
            yield drive, goal["id"]


async def arrives(rest: RestClient, building: SimulatedBuilding, drive: Drive, goal_id: str) -> None:
    last = await ended(rest, "porter", goal_id)
    assert last["state"] == "succeeded", last
    assert floor_of_robot(building) == "L2"
    assert building.robots[0].base.pose.distance_to(GOAL) < 0.35
    assert drive.scorer.collisions(0) == 0


async def test_a_robot_in_a_lift_arrives_although_its_machine_is_killed(tmp_path: Path) -> None:
    building = simulated_building()
    with running_cloud(tmp_path, *OPTIONS, "--listen-machines", "127.0.0.1:0", "--adopt-within", "2") as cloud:
        rest, second = await cloud.admin(), JoinedMachine(tmp_path / "m2", "m2")
        second.start(ticket(tmp_path / "data"))
        await second.is_in(rest)
        await rest.patch("/v1/machines/local", {"max_containers": 0})
        async with travelling(rest, cloud.url, building) as (drive, goal_id):
            assert (await container_of(rest, "porter"))["machine"] == "m2"
            await rest.patch("/v1/machines/local", {"max_containers": 10})
            await until(lambda: floor_of_robot(building) == "L2", 60.0)
            second.signal(signal.SIGKILL)
            assert await second.has_ended() == -signal.SIGKILL
            await arrives(rest, building, drive, goal_id)
            assert (await container_of(rest, "porter"))["machine"] == "local"


async def test_nobody_holds_a_lift_whose_cloud_was_killed(tmp_path: Path) -> None:
    building = simulated_building()
    with running_cloud(tmp_path, *OPTIONS) as cloud:
        async with travelling(await cloud.admin(), cloud.url, building):
            await until(lambda: session(building) != "", 30.0)
            began = building.time()
            kill(cloud)
            await until(lambda: session(building) == "", 30.0)
            assert building.time() - began < 11.0


async def test_a_robot_leaves_a_lift_in_case_of_fire_and_goes_on_afterwards(tmp_path: Path) -> None:
    building = simulated_building()
    lift = building.lifts[LIFT]
    with running_cloud(tmp_path, *OPTIONS) as cloud:
        rest = await cloud.admin()
        async with travelling(rest, cloud.url, building) as (drive, first):
            await until(lambda: floor_of_robot(building) == "L2", 60.0)
            lift.set_mode("fire", building.time())
            await until(lambda: floor_of_robot(building) == "L1", 30.0)  # a lift drives to the lowest floor
            await until(lambda: building.robots[0].base.pose.y < 2.2, 60.0)  # it is out
            lift.set_mode("agv", building.time())
            last = await ended(rest, "porter", first)
            if last["state"] != "succeeded":
                assert "fire" in last["text"], last
                last = await rest.post("/v1/robots/porter/goals", {"pose": list(GOAL), "floor": "L2"})
            await arrives(rest, building, drive, last["id"])


def kill(cloud: RunningCloud) -> None:
    os.kill(cloud.pid, signal.SIGKILL)
    cloud.status = -signal.SIGKILL
