"""A robot with a depth camera that sees people and follows them.

python people_turtlebot.py ROBOT     reads PPAAS_URL and PPAAS_TOKEN from the environment; you write hardware.py
"""

import asyncio
import os
import sys

import hardware

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.geometry_msgs import (
    Pose,
    PoseWithCovariance,
    Quaternion,
    Transform,
    TransformStamped,
    Twist,
    TwistWithCovariance,
    Vector3,
)  # fmt: skip
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.perception.compressed_depth import compress
from robots.client import RobotClient
from robots.onboard import BaseController, run_local_nodes, this_computer

WIDTH, HEIGHT, FX, FY, CX, CY = 640, 480, 575.8, 575.8, 319.5, 239.5  # of your camera [pixels]
MOUNT = Transform(Vector3(x=0.0, y=0.0, z=1.0), Quaternion(z=0.0, w=1.0))  # of the camera on base_link: level, 1 m high
OPTICAL = Transform(Vector3(), Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5))  # z ahead, x to the right
FRAME = "camera_depth_optical_frame"
PERIOD, IMAGE_PERIOD = 0.05, 0.2  # [s]


async def base(cloud):
    """Send odometry, and execute velocity commands."""
    controller = BaseController()  # stops the base if no command arrives for half a second
    await cloud.subscribe("cmd_vel", Twist, controller.command, queue_size=1)
    while True:
        x, y, yaw, v, w = hardware.odometry()
        pose, twist = Pose.of(Pose2D(x, y, yaw)), Twist(Vector3(x=v), Vector3(z=w))
        odom = Odometry(Header(frame_id="odom"), "base_link", PoseWithCovariance(pose), TwistWithCovariance(twist))
        await cloud.publish("odom", odom, newest_only=True)
        hardware.drive(*controller.velocity())
        await asyncio.sleep(PERIOD)


async def camera(cloud):
    """Send the mount of the camera, and depth images."""
    mount = TransformStamped(Header(frame_id="base_link"), "camera_depth_frame", MOUNT)
    optical = TransformStamped(Header(frame_id="camera_depth_frame"), FRAME, OPTICAL)
    await cloud.publish("tf_static", TFMessage([mount, optical]))
    while True:
        stamp, depths = hardware.depths()
        header = Header(stamp=Time.of(stamp), frame_id=FRAME)
        projection = [FX, 0.0, CX, 0.0, 0.0, FY, CY, 0.0, 0.0, 0.0, 1.0, 0.0]
        intrinsics = [FX, 0.0, CX, 0.0, FY, CY, 0.0, 0.0, 1.0]
        info = CameraInfo(header, height=HEIGHT, width=WIDTH, K=intrinsics, P=projection)
        await cloud.publish("camera/depth/camera_info", info, newest_only=True)
        image = CompressedImage(header, *await asyncio.to_thread(compress, depths))
        await cloud.publish("camera/depth/image_raw/compressedDepth", image, newest_only=True)
        await asyncio.sleep(IMAGE_PERIOD)


async def main(robot):
    url = os.environ.get("PPAAS_URL", "http://127.0.0.1:8500")
    computer = await asyncio.to_thread(this_computer)
    async with RobotClient(url, robot=robot, token=os.environ["PPAAS_TOKEN"]) as cloud, asyncio.TaskGroup() as group:
        group.create_task(base(cloud))
        group.create_task(camera(cloud))
        # The detector runs on the robot or in the cloud, wherever it performs better.
        group.create_task(run_local_nodes(cloud, computer, {"torso_detector": ""}, print))


asyncio.run(main(sys.argv[1]))
