"""Robots that are brought to another map go on there in the same session."""

import asyncio
import os
import signal
from contextlib import AsyncExitStack
from typing import Any

import pytest

from ppaas.errors import PPaaSError
from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.maps.occupancy import from_message
from ppaas.messages.nav_msgs import OccupancyGrid
from robots.client.rest import RestClient
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

GROUND = walled_map(6.6, 4.5, [(4.3, 1.1, 4.5, 3.4), (1.0, 3.0, 1.6, 3.4)])
SHIFT = Pose2D(10.0, -3.0, 0.0)
"""Where the frame of the lower map is in the other one: the same hall, in other coordinates."""

UPPER = GridMap(GROUND.data, GridInfo(GROUND.info.resolution, GROUND.info.width, GROUND.info.height, SHIFT))
START = Pose2D(0.6, 0.8, 0.0)


async def wait_until_at(drive: Drive, frame: Pose2D) -> None:
    """Wait until the robot is localized where it really is, in the coordinates of a map."""
    await until(lambda: drive.estimate().distance_to(frame @ drive.world.robots[0].base.pose) < 0.15, 15.0)


async def pid_of(rest: RestClient, robot: str) -> int:
    [found] = [one for one in await rest.items("/v1/containers") if one["robot"] == robot]
    return int(found["pid"] or 0)


async def ended(rest: RestClient, robot: str, goal: dict[str, Any]) -> dict[str, Any]:
    """Wait for the end of a goal, and return it."""
    async with asyncio.timeout(60.0):
        while (last := await rest.get(f"/v1/robots/{robot}/goals/{goal['id']}"))["state"] in ("pending", "active"):
            await asyncio.sleep(0.1)
    return last


async def drive_to(rest: RestClient, robot: str, pose: Pose2D) -> None:
    """Send a robot to a pose, and wait until it is there."""
    last = await ended(rest, robot, await rest.post(f"/v1/robots/{robot}/goals", {"pose": list(pose)}))
    assert last["state"] == "succeeded", last


async def test_a_robot_goes_on_on_another_map_with_its_socket_its_topics_and_its_name(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "ground", GROUND)
    await publish_map(rest, "upper", UPPER)
    token = await register_robot(rest, "rider1", "ground", tuple(START))
    async with AsyncExitStack() as stack:
        drive = await stack.enter_async_context(driving(cloud.url, token, "rider1", GROUND, START))
        maps: list[GridMap] = []
        await drive.operator.subscribe("map", OccupancyGrid, lambda message: maps.append(from_message(message)))
        await until(lambda: bool(maps) and bool(drive.poses))
        goal = await rest.post("/v1/robots/rider1/goals", {"pose": [3.5, 0.8, 0.0]})
        await until(lambda: drive.world.robots[0].base.pose.x > 1.0, 30.0)
        before = await pid_of(rest, "rider1")
        there = SHIFT @ drive.world.robots[0].base.pose
        moved = await rest.post("/v1/robots/rider1/move", {"map": "upper", "pose": list(there)})
        assert (moved["map"], moved["initial_pose"]) == ("upper", list(there))
        await wait_until_at(drive, SHIFT)
        assert await pid_of(rest, "rider1") != before
        last = await ended(rest, "rider1", goal)
        assert last["state"] == "canceled" and "another map" in last["text"]
        await until(lambda: maps[-1].info.origin == SHIFT)
        await drive_to(rest, "rider1", SHIFT @ Pose2D(3.0, 0.8, 0.0))
        assert drive.scorer.error(0, Pose2D(3.0, 0.8, 0.0)) <= 0.3 and drive.scorer.collisions(0) == 0
        assert (await rest.get("/v1/robots/rider1/state"))["connected"]
        # Killed in the middle: the next container is on the map below, where the robot was put.
        await rest.post("/v1/robots/rider1/move", {"map": "ground", "pose": list(drive.world.robots[0].base.pose)})
        os.kill(await pid_of(rest, "rider1") or cloud.container().pid, signal.SIGKILL)
        await wait_until_at(drive, Pose2D(0.0, 0.0))
        await drive_to(rest, "rider1", Pose2D(1.5, 0.8, 0.0))


async def test_what_cannot_be_is_refused_and_changes_nothing(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, "ground", GROUND)
    await publish_map(rest, "upper", UPPER)
    await register_robot(rest, "rider2", "ground", tuple(START), {"keepout_filter": {"filter_mask": "ground"}})
    for name, reason in (("nowhere", "nowhere"), ("upper", "masks of map 'ground'")):
        with pytest.raises(PPaaSError, match=reason):
            await rest.post("/v1/robots/rider2/move", {"map": name, "pose": [0.0, 0.0, 0.0]})
    assert (await rest.get("/v1/robots/rider2"))["map"] == "ground"
