"""A robot with a 3D lidar: the cloud makes a 2D and a 3D map of its world, and publishes both as one version."""

import math
from typing import Any

import msgspec
import numpy as np
import pytest

from ppaas.maps.grid import GridMap
from ppaas.maps.octomap import parse_octomap
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.octomap_msgs import GetOctomap, GetOctomapResponse, Octomap
from ppaas.messages.sensor_msgs import LaserScan, PointCloud2
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud
from tests.support.cloud.drive import driving
from tests.support.waiting import until
from tests.support.world.cloud_robot import cloud_message
from tests.support.world.places import free_pose

pytestmark = pytest.mark.journey

HEIGHTS = (0.025, 0.525)
"""Heights of the points above the laser [m]."""


class LidarRobot(RobotClient):
    """Sends a point cloud with each laser scan: its points at two heights."""

    async def publish(self, topic: str, message: Message, **options: Any) -> Any:
        if isinstance(message, LaserScan):
            await super().publish("cloud_in", cloud_of(message), **options)
        return await super().publish(topic, message, **options)


def cloud_of(scan: LaserScan) -> PointCloud2:
    ranges = np.array([math.nan if value is None else value for value in scan.ranges])
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    level = np.stack([ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(ranges))], axis=1)
    seen = level[np.isfinite(ranges) & (ranges < scan.range_max)]
    points = np.concatenate([seen + np.array([0.0, 0.0, height]) for height in HEIGHTS]).astype(np.float32)
    return cloud_message(points, scan.header.stamp.seconds(), scan.header.frame_id)


async def test_a_3d_map_is_made_beside_the_2d_map_and_published_with_it(
    cloud: RunningCloud, office_map: GridMap
) -> None:
    rest, robot = await cloud.admin(), "cubist"
    parameters = {"octomap_server": {"sensor_model": {"max_range": 6.0}}}
    await rest.put_robot(robot, RobotFile(map="new:rooms", parameters=parameters))
    assert rest.token is not None
    octomaps: list[Octomap] = []
    async with driving(
        cloud.url, rest.token, robot, office_map, free_pose(office_map, seed=4), client=LidarRobot
    ) as drive:
        await drive.operator.subscribe("octomap_binary", Octomap, octomaps.append)
        await until(lambda: any(nodes_of(octomap) for octomap in octomaps), 60)
        answer = await drive.operator.call("octomap_full", GetOctomap, Empty())
        assert isinstance(answer, GetOctomapResponse)
        assert len(nodes_of(answer.map)) > len(nodes_of(octomaps[-1])) > 100
        published = await rest.with_timeout(120.0).post(f"/v1/robots/{robot}/map", {"publish": "rooms"})
    assert published["parts"] == ["image", "octomap", "posegraph", "yaml"]
    tree = parse_octomap(await rest.fetch("/v1/maps/rooms/octomap"))
    layers = np.unique(tree.corners[tree.occupied][:, 2].astype(int))
    assert np.diff(layers).tolist() == [10]  # voxels of 0.05 m: the two heights of the points
    assert tree.occupied.sum() > 100


def nodes_of(octomap: Octomap) -> list[int]:
    return msgspec.json.decode(octomap.data) if isinstance(octomap.data, msgspec.Raw) else octomap.data
