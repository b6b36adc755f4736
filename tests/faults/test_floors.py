"""SIGKILL of clone and cloud while a robot is in a lift: the next process leads it on to its floor, and its task."""

import os
import signal
from pathlib import Path

import pytest

from tests.support.cloud.cloud import register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import GOAL, START, ended, ended_task, put_building, simulated_building, simulating
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


async def test_a_task_over_floors_is_done_once_although_clone_and_cloud_are_killed(tmp_path: Path) -> None:
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
                body = {"kind": "patrol", "places": [list(START), list(GOAL)], "floors": [None, "L2"]}
                task = await rest.post("/v1/maps/floor-1/tasks", body)
                assert (task["floors"], task["state"]) == (["L1", "L2"], "queued")
                await until(lambda: building.floor_of(building.robots[0]) == "L2", 60.0)
                os.kill(cloud.container().pid, signal.SIGKILL)
                os.kill(cloud.pid, signal.SIGKILL)
                cloud.status = -signal.SIGKILL
                wire.cut()
                (tmp_path / "ready.json").unlink()
                with running_cloud(tmp_path, *options) as second:
                    wire.mend(second.url)
                    again = await second.admin()
                    last = await ended_task(again, f"/v1/maps/floor-1/tasks/{task['id']}")
                    done = last["state"], last["visited"], last["failures"], last["robot"]
                    assert done == ("done", 2, 0, "porter"), last
                    assert building.floor_of(building.robots[0]) == "L2"
                    assert building.robots[0].base.pose.distance_to(GOAL) < 0.35
                    journeys = await again.items("/v1/robots/porter/goals")
                    assert [goal["id"] for goal in journeys] == [f"task-{task['id']}-1-0"]
