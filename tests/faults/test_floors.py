"""SIGKILL of clone and cloud while a robot is in a lift: the next process leads it on to its floor, and its task."""

import os
import signal
from pathlib import Path

import pytest

from ppaas.geometry import Pose2D
from tests.support.cloud.cloud import register_robot, running_cloud
from tests.support.cloud.drive import driving
from tests.support.cloud.floors import (
    BETWEEN,
    GOAL,
    GROUND,
    LOFT,
    START,
    carried,
    ended,
    ended_task,
    put_building,
    world_of,
)
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


async def test_a_task_over_floors_is_done_once_although_clone_and_cloud_are_killed(tmp_path: Path) -> None:
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
            body = {"kind": "patrol", "places": [list(START), list(GOAL)], "floors": [None, "L2"]}
            task = await clients[0].post("/v1/maps/floor-1/tasks", body)
            assert (task["floors"], task["state"]) == (["L1", "L2"], "queued")
            await until(lambda: len(maps) > 1, 60.0)
            os.kill(cloud.container().pid, signal.SIGKILL)
            os.kill(cloud.pid, signal.SIGKILL)
            cloud.status = -signal.SIGKILL
            wire.cut()
            (tmp_path / "ready.json").unlink()
            with running_cloud(tmp_path, "--adopt-within", "120") as second:
                wire.mend(second.url)
                clients.append(await second.admin())
                last = await ended_task(clients[-1], f"/v1/maps/floor-1/tasks/{task['id']}")
                assert (last["state"], last["visited"], last["failures"], last["robot"]) == ("done", 2, 0, "porter"), (
                    last
                )
                assert maps == ["floor-1", "floor-2"]
                assert drive.world.robots[0].base.pose.distance_to(Pose2D(GOAL.x + BETWEEN, GOAL.y)) < 0.35
                journeys = await clients[-1].items("/v1/robots/porter/goals")
                assert [goal["id"] for goal in journeys] == [f"task-{task['id']}-1-0"]
