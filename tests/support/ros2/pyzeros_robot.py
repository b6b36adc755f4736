"""Robot on pyzeros, ROS 2 over Zenoh in Python alone: run by the Python that has it, without this project.

``python pyzeros_robot.py ENDPOINT GRID.npz X Y YAW GOAL_X GOAL_Y`` connects to a router, drives in the cells of
``grid``, and sends the goal by ``goal_pose``. It prints as JSON where it stopped and what it received. Without
arguments it compiles the codecs of its messages, which pyzeros keeps: minutes, once.
"""

import asyncio
import json
import math
import sys
import time
from typing import Any

import asyncio_for_robotics as afor
import numpy as np
import pyzeros
import zenoh
from grid_robot import BEAMS, RANGE, GridRobot
from pyzeros.qos import QosProfile
from ros2_pyterfaces.cydr.all_msgs import LaserScan, Odometry, PoseStamped, Time, Twist

TIMEOUT, NEAR = 150.0, 0.3
SENSOR = QosProfile(reliability="best_effort", depth=5)


class Robot:
    """Turtlebot in the cells of a map."""

    def __init__(self, node: pyzeros.Node, body: GridRobot) -> None:
        self.body = body
        self.received = {"cmd_vel": 0}
        self.scans = node.create_publisher(LaserScan, "scan", SENSOR)
        self.odometry = node.create_publisher(Odometry, "odom")
        self.goals = node.create_publisher(PoseStamped, "goal_pose")
        self.commands = node.create_subscriber(Twist, "cmd_vel")

    async def follow(self) -> None:
        async for twist in self.commands.listen_reliable():
            self.received["cmd_vel"] += 1
            self.body.drive(float(twist.linear.x), float(twist.angular.z))

    def measure(self) -> None:
        speed, turn = self.body.step()
        message, (x, y, yaw) = Odometry(), self.body.odometry()
        message.header.stamp, message.header.frame_id, message.child_frame_id = now(), b"odom", b"base_link"
        message.pose.pose.position.x, message.pose.pose.position.y = np.float64(x), np.float64(y)
        message.pose.pose.orientation.z = np.float64(math.sin(yaw / 2))
        message.pose.pose.orientation.w = np.float64(math.cos(yaw / 2))
        message.twist.twist.linear.x, message.twist.twist.angular.z = np.float64(speed), np.float64(turn)
        self.odometry.publish(message)

    def scan(self) -> None:
        message = LaserScan()
        message.header.stamp, message.header.frame_id = now(), b"base_link"
        step = 2 * math.pi / BEAMS
        message.angle_min, message.angle_max = np.float32(-math.pi), np.float32(math.pi - step)
        message.angle_increment = np.float32(step)
        message.range_min, message.range_max = np.float32(0.1), np.float32(RANGE)
        message.ranges = self.body.ranges()
        self.scans.publish(message)

    def send(self, x: float, y: float) -> None:
        message = PoseStamped()
        message.header.frame_id = b"map"
        message.pose.position.x, message.pose.position.y = np.float64(x), np.float64(y)
        message.pose.orientation.w = np.float64(1.0)
        self.goals.publish(message)


def now() -> Any:
    """Return the time as a stamp."""
    seconds = time.time()
    return Time(np.int32(int(seconds)), np.uint32(int(seconds % 1.0 * 1e9)))


@afor.scoped
async def drive(node: pyzeros.Node, body: GridRobot, goal: list[float]) -> Robot:
    """Drive to the goal; send it again while nothing moves, for the clone may not be localized yet."""
    robot = Robot(node, body)
    afor.Scope.current().task_group.create_task(robot.follow())
    began, sent, steps = time.monotonic(), time.monotonic(), 0
    while time.monotonic() - began < TIMEOUT:
        robot.measure()
        if steps % 2 == 0:
            robot.scan()
        if not robot.received["cmd_vel"] and time.monotonic() - sent > 3.0:
            robot.send(*goal)
            sent = time.monotonic()
        if robot.received["cmd_vel"] and body.stands() and math.dist(body.pose[:2], goal) < NEAR:
            break
        steps += 1
        await asyncio.sleep(0.05)
    return robot


def main() -> None:
    """Drive, and print what happened."""
    if len(sys.argv) == 1:
        for kind in (LaserScan, Odometry, PoseStamped, Twist):
            kind().serialize()
        return
    config = zenoh.Config()
    for key, value in (("mode", "client"), ("connect/endpoints", [sys.argv[1]]), ("scouting/multicast/enabled", False)):
        config.insert_json5(key, json.dumps(value))
    numbers = [float(one) for one in sys.argv[3:8]]
    body = GridRobot(np.load(sys.argv[2])["grid"], numbers[:3])
    with pyzeros.auto_context(node="turtlebot", zenoh_session=zenoh.open(config), namespace="/tb3") as node:
        robot = asyncio.run(drive(node, body, numbers[3:]))
    sys.stdout.write(json.dumps(robot.received | {"pose": body.pose}))


if __name__ == "__main__":
    main()
