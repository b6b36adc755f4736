"""Robots that drive go on with a new version of their map."""

import os
import signal
from contextlib import AsyncExitStack

import numpy as np
import pytest

from ppaas.geometry import Pose2D
from ppaas.maps.grid import GridMap
from ppaas.maps.occupancy import from_message, from_update
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.map_msgs import OccupancyGridUpdate
from ppaas.messages.nav_msgs import OccupancyGrid, Path
from tests.support.cloud.cloud import RunningCloud, publish_map, register_robot
from tests.support.cloud.drive import Drive, driving
from tests.support.waiting import until
from tests.support.world.planar_world import walled_map

pytestmark = pytest.mark.journey

MAP = "swapped"
WALL = [(4.3, 1.1, 4.5, 3.4)]
"""Wall across a hall; robots pass it below or above."""

BEFORE = walled_map(6.6, 4.5, WALL)
AFTER = walled_map(6.6, 4.5, [*WALL, (4.3, 0.0, 4.5, 1.2)])
"""The passage below is closed."""

ROBOTS = {
    "swap1": (Pose2D(0.5, 0.7, 0.0), Pose2D(5.9, 0.7, 0.0)),
    "swap2": (Pose2D(0.5, 1.6, 0.0), Pose2D(5.9, 1.6, 0.0)),
}


class Seen:
    """Map and plans of a robot, as an operator sees them."""

    def __init__(self) -> None:
        self.maps: list[GridMap] = []
        self.updates: list[OccupancyGridUpdate] = []
        self.plans: list[list[float]] = []

    async def watch(self, drive: Drive) -> None:
        await drive.operator.subscribe("map", OccupancyGrid, lambda message: self.maps.append(from_message(message)))
        await drive.operator.subscribe("map_updates", OccupancyGridUpdate, self.updates.append)
        await drive.operator.subscribe("plan", Path, self._plan)

    def _plan(self, path: Path) -> None:
        crossing = [pose.pose.position.y for pose in path.poses if 4.2 < pose.pose.position.x < 4.6]
        if crossing:
            self.plans.append(crossing)

    def updated(self) -> GridMap:
        """Return the first map with all changes."""
        data = self.maps[0].data.copy()
        for update in self.updates:
            row, column, cells = from_update(update)
            data[row : row + cells.shape[0], column : column + cells.shape[1]] = cells
        return GridMap(data, self.maps[0].info)


async def test_driving_robots_go_around_a_wall_of_a_version_published_meanwhile(cloud: RunningCloud) -> None:
    rest = await cloud.admin()
    await publish_map(rest, MAP, BEFORE)
    async with AsyncExitStack() as stack:
        drives, seen = {}, {}
        for name, (start, _) in ROBOTS.items():
            token = await register_robot(rest, name, MAP, tuple(start))
            drives[name] = await stack.enter_async_context(driving(cloud.url, token, name, AFTER, start))
            seen[name] = Seen()
            await seen[name].watch(drives[name])
        for name, (_, goal) in ROBOTS.items():
            await drives[name].send(goal)
        await until(lambda: all(one.plans and one.maps for one in seen.values()))
        assert all(max(one.plans[0]) < 1.3 for one in seen.values()), "through the passage below"
        await publish_map(rest, MAP, AFTER)
        version = (await rest.get(f"/v1/maps/{MAP}"))["version"]
        await until(lambda: all(one.updates for one in seen.values()))
        await until(lambda: all(min(one.plans[-1]) > 3.2 for one in seen.values()), 10.0)
        containers = {one["robot"]: one for one in await rest.items("/v1/containers") if one["robot"] in ROBOTS}
        assert {one["map"]["version"] for one in containers.values()} == {version}
        os.kill(containers["swap2"]["pid"], signal.SIGKILL)
        for name, (_, goal) in ROBOTS.items():
            result = await drives[name].result()
            assert result.status.status == Status.SUCCEEDED, result.status.text
            assert drives[name].scorer.error(0, goal) <= 0.25
            assert drives[name].scorer.collisions(0) == 0
        assert len(seen["swap1"].maps) == 1, "only changes were sent"
        np.testing.assert_array_equal(seen["swap1"].updated().data, AFTER.data)
        assert sum(one.width * one.height for one in seen["swap1"].updates) < AFTER.data.size / 2
        replaced = [one for one in await rest.items("/v1/containers") if one["robot"] == "swap2"]
        assert [one["pid"] for one in replaced] != [containers["swap2"]["pid"]]
        np.testing.assert_array_equal(seen["swap2"].maps[-1].data, AFTER.data)
