"""A Turtlebot with a depth camera in place of its laser: it sends images, and the cloud drives it."""

from typing import Any

import numpy as np
import pytest

from ppaas.maps.grid import GridMap
from ppaas.messages.base.message import Message
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, LaserScan
from ppaas.perception.compressed_depth import compress
from robots.client.robot_client import RobotClient
from robots.client.robot_file import RobotFile
from tests.support.cloud.cloud import RunningCloud, publish_map
from tests.support.cloud.drive import driving
from tests.support.cloud.local_nodes import ABLE, managing, take_over
from tests.support.waiting import until
from tests.support.world.places import free_pose, reachable_pose

pytestmark = pytest.mark.journey

WIDTH, HEIGHT, FOCAL = 320, 4, 110.0
"""A wide view, as of two cameras: 111°."""

INFO, IMAGE = "camera/depth/camera_info", "camera/depth/image_raw/compressedDepth"

FRAME = "base_link"
PARAMETERS = {"depthimage_to_laserscan": {"scan_height": 2, "output_frame_id": FRAME, "range_min": 0.1}}


class CameraRobot(RobotClient):
    """Sends images of a camera in place of laser scans."""

    async def publish(self, topic: str, message: Message, **options: Any) -> Any:
        if not isinstance(message, LaserScan) or message.angle_max < 1.0:  # of an image already
            return await super().publish(topic, message, **options)
        k = [FOCAL, 0.0, (WIDTH - 1) / 2, 0.0, FOCAL, (HEIGHT - 1) / 2, 0.0, 0.0, 1.0]
        await super().publish(INFO, CameraInfo(message.header, HEIGHT, WIDTH, k))
        image = CompressedImage(message.header, *compress(picture(message)))
        return await super().publish(IMAGE, image, **options)


def picture(scan: LaserScan) -> np.ndarray:
    """Return the image of a camera at the pose of a laser scan; its lower rows show the floor."""
    angles = -np.arctan((np.arange(WIDTH) - (WIDTH - 1) / 2) / FOCAL)
    beams = np.rint((angles - scan.angle_min) / scan.angle_increment).astype(int) % len(scan.ranges)
    ranges = np.array(scan.ranges, float)[beams]
    image = np.full((HEIGHT, WIDTH), 300, np.uint16)
    image[:2] = np.nan_to_num(1000.0 * ranges * np.cos(angles), nan=0.0, posinf=0.0)
    return image


async def test_a_robot_with_a_depth_camera_is_localized_and_driven(cloud: RunningCloud, office_map: GridMap) -> None:
    rest, robot = await cloud.admin(), "tb-depth"
    await publish_map(rest, "office", office_map)
    start = free_pose(office_map, seed=1)
    goal = reachable_pose(office_map, start, seed=2, at_least=2.0, at_most=3.5)
    await rest.put_robot(
        robot, RobotFile(map="office", model="turtlebot3_burger", initial_pose=start, parameters=PARAMETERS)
    )
    assert rest.token is not None
    heard: list[LaserScan] = []
    images: list[CompressedImage] = []
    async with driving(cloud.url, rest.token, robot, office_map, start, client=CameraRobot) as drive:
        await drive.operator.subscribe("scan", LaserScan, heard.append)
        await drive.operator.subscribe(IMAGE, CompressedImage, images.append)
        assert await drive.go(goal) <= 0.25
        assert images
        async with managing(drive.robot, ABLE, sensors=("odom", INFO, IMAGE)) as manager:
            await take_over(manager, "depthimage_to_laserscan")
            images.clear()
            heard.clear()
            located = len(drive.poses)
            await until(lambda: len(heard) > 10 and len(drive.poses) > located + 5, 30)
            assert not images, "the robot's own computer makes the scans"
        assert drive.scorer.collisions(0) == 0
    assert heard[-1].header.frame_id == FRAME
    assert heard[-1].angle_max < 1.0
