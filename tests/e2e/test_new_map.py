"""A robot without a map: it drives to a goal beyond its first view, while the cloud maps."""

import asyncio
import contextlib
from collections.abc import Callable

import numpy as np
import pytest

from ppaas.errors import Unavailable
from ppaas.geometry import Pose2D
from ppaas.maps.free_space import distance_to_occupied
from ppaas.maps.grid import FREE, OCCUPIED, UNKNOWN, GridMap
from ppaas.maps.occupancy import from_message
from ppaas.maps.raycast import cast_rays
from ppaas.messages.base.message import Empty
from ppaas.messages.nav_msgs import GetMap, GetMapResponse, OccupancyGrid
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud
from tests.support.cloud.drive import driving
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

ROBOT, NEW_MAP = "scout", "new:office-2"


def hidden_pose(world: GridMap, start: Pose2D) -> Pose2D:
    """Return a pose that can be reached from another, and not be seen from there."""
    for seed in range(100):
        goal = reachable_pose(world, start, seed, at_least=3.0, at_most=5.0)
        away, bearing = start.distance_to(goal), np.arctan2(goal.y - start.y, goal.x - start.x)
        seen = cast_rays(world.data >= OCCUPIED, world.info, Pose2D(start.x, start.y), [bearing], 20.0)
        if seen[0] < away - 0.5:
            return goal
    raise AssertionError("every pose is seen from the start")


async def map_of(operator: RobotClient) -> GridMap:
    answer = await operator.call("dynamic_map", GetMap, Empty())
    assert isinstance(answer, GetMapResponse)
    return from_message(answer.map)


def wrong_parts(made: GridMap, world: GridMap, start: Pose2D) -> tuple[float, float]:
    """Return the parts of a map's occupied and free cells that are not so in the world; ``start`` is its origin."""
    away = distance_to_occupied(world)
    parts = []
    for value in (OCCUPIED, FREE):
        points = made.info.to_world(np.argwhere(made.data == value))
        cos, sin = np.cos(start.theta), np.sin(start.theta)
        x, y = start.x + cos * points[:, 0] - sin * points[:, 1], start.y + sin * points[:, 0] + cos * points[:, 1]
        cells = np.array([world.info.cell_of(*point) or (0, 0) for point in zip(x.tolist(), y.tolist(), strict=True)])
        distance = away[cells[:, 0], cells[:, 1]]
        parts.append(float(np.mean(distance > 0.1 if value == OCCUPIED else distance == 0.0)))
    return parts[0], parts[1]


async def show(rest: RestClient) -> dict[str, object]:
    (container,) = [c for c in (await rest.get("/v1/containers"))["items"] if c["robot"] == ROBOT]
    return dict(container)


async def test_a_robot_maps_while_it_drives_beyond_its_first_view(cloud: RunningCloud, office_map: GridMap) -> None:
    rest = await cloud.admin()
    start = free_pose(office_map, seed=4)
    goal = hidden_pose(office_map, start)
    target = start.inverse() @ goal  # the frame of the map is that of the odometry, which starts with the robot
    await rest.put_robot(ROBOT, RobotFile(map=NEW_MAP, parameters={"amcl": {"max_particles": 900}}))
    assert rest.token is not None
    maps: list[OccupancyGrid] = []
    async with driving(cloud.url, rest.token, ROBOT, office_map, start) as drive:
        await drive.operator.subscribe("map", OccupancyGrid, maps.append)
        await until(lambda: maps, 30)
        first = from_message(maps[0])
        cell = first.info.cell_of(target.x, target.y)
        assert cell is None or first.data[cell] == UNKNOWN
        assert (await show(rest))["map"] == {"id": NEW_MAP, "version": ""}

        await drive.go(target)
        assert drive.world.robots[0].base.pose.distance_to(goal) <= 0.25
        assert drive.scorer.collisions(0) == 0
        state = await rest.get(f"/v1/robots/{ROBOT}/state")
        assert drive.world.robots[0].base.pose.distance_to(start @ Pose2D(*state["pose"])) <= 0.1

        made = await map_of(drive.operator)
        assert np.sum(made.data != UNKNOWN) > 1.2 * np.sum(first.data != UNKNOWN)
        occupied, free = wrong_parts(made, office_map, start)
        assert occupied <= 0.02
        assert free <= 0.01

        before = (await rest.get(f"/v1/robots/{ROBOT}/map"))["key_frames"]
        killed = cloud.container()
        killed.kill()
        after = await map_after(rest, lambda container: container["pid"] != killed.pid)
        assert after["key_frames"] >= before - 1
        again = await map_of(drive.operator)
        assert np.sum(again.data != UNKNOWN) >= 0.99 * np.sum(made.data != UNKNOWN)

        published = await rest.with_timeout(120.0).post(f"/v1/robots/{ROBOT}/map", {"publish": "office-2"})
        assert published["parts"] == ["image", "posegraph", "yaml"]
        assert (published["owner"], published["resolution"]) == ("admin", 0.05)

    continued = {"map_file_name": "office-2", "mode": "localization", "map_start_pose": [0.3, 0.0, 0.0]}
    await rest.put_robot("second", RobotFile(map=NEW_MAP, parameters={"grid_slam": continued}))
    async with driving(cloud.url, rest.token, "second", office_map, start):
        while (state := await rest.get("/v1/robots/second/state"))["pose"] is None:
            await asyncio.sleep(0.1)
    np.testing.assert_allclose(state["pose"], (0.0, 0.0, 0.0), atol=0.05)


async def map_after(rest: RestClient, ready: Callable[[dict[str, object]], bool]) -> dict[str, int]:
    """Return the size of the robot's map, once its container is as required."""
    while True:
        with contextlib.suppress(Unavailable):
            if ready(await show(rest)):
                return dict(await rest.get(f"/v1/robots/{ROBOT}/map"))
        await asyncio.sleep(0.05)
