"""A complete robot: sends odometry and scans to the cloud, and executes its velocity commands.

python robot.py ROBOT     reads PPAAS_URL and PPAAS_TOKEN from the environment; you write hardware.py
"""

import asyncio
import math
import os
import sys

import hardware

from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance, Vector3
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.sensor_msgs import LaserScan
from robots.client import RobotClient
from robots.onboard import BaseController


async def main(robot):
    base = BaseController()  # stops the base if no command arrives for half a second
    url = os.environ.get("PPAAS_URL", "http://127.0.0.1:8500")
    async with RobotClient(url, robot=robot, token=os.environ["PPAAS_TOKEN"]) as cloud:
        await cloud.subscribe("cmd_vel", Twist, base.command, queue_size=1)
        while True:
            x, y, yaw, v, w = hardware.odometry()
            pose, twist = Pose.of(Pose2D(x, y, yaw)), Twist(Vector3(x=v), Vector3(z=w))
            odom = Odometry(Header(frame_id="odom"), "base_link", PoseWithCovariance(pose), TwistWithCovariance(twist))
            await cloud.publish("odom", odom, newest_only=True)
            scan = LaserScan(Header(frame_id="base_link"), -math.pi, math.pi, math.pi / 180, 0.12, 8.0, hardware.scan())
            await cloud.publish("scan", scan, newest_only=True)
            hardware.drive(*base.velocity())
            await asyncio.sleep(0.1)


asyncio.run(main(sys.argv[1]))
