"""Robot written on rclpy, with its own physics: run by the Python that has ROS 2, without this project.

``python rclpy_robot.py GRID.npz X Y YAW GOAL_X GOAL_Y`` drives in the cells of ``grid`` (5 cm each). It sends the goal
by ``goal_pose``, requests the map if a node serves it, and prints as JSON where it stopped and what it received.
"""

import json
import math
import sys
import time

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from grid_robot import BEAMS, RANGE, GridRobot
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetMap
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TIMEOUT, NEAR = 70.0, 0.3


class Robot(Node):
    """Turtlebot in the cells of a map."""

    def __init__(self, grid: np.ndarray, pose: list[float], goal: list[float]) -> None:
        super().__init__("turtlebot")
        self.body, self.goal = GridRobot(grid, pose), goal
        self.received = {"cmd_vel": 0, "map": 0, "plan": 0}
        self.sent = 0.0
        self.scans = self.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
        self.odometry = self.create_publisher(Odometry, "odom", 10)
        self.goals = self.create_publisher(PoseStamped, "goal_pose", 10)
        self.create_subscription(Twist, "cmd_vel", self.drive, 10)
        self.create_subscription(OccupancyGrid, "map", lambda _: self.count("map"), LATCHED)
        self.create_subscription(Path, "plan", lambda _: self.count("plan"), 10)
        self.create_timer(0.05, self.step)
        self.create_timer(0.1, self.scan)

    def count(self, topic: str) -> None:
        self.received[topic] += 1

    def drive(self, twist: Twist) -> None:
        self.count("cmd_vel")
        self.body.drive(twist.linear.x, twist.angular.z)

    def step(self) -> None:
        self.odometry.publish(self.measured(*self.body.step()))

    def measured(self, speed: float, turn: float) -> Odometry:
        message = Odometry()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id, message.child_frame_id = "odom", "base_link"
        x, y, yaw = self.body.odometry()
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        message.twist.twist.linear.x, message.twist.twist.angular.z = speed, turn
        return message

    def scan(self) -> None:
        message = LaserScan()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = "base_link"
        message.angle_min, message.angle_increment = -math.pi, 2 * math.pi / BEAMS
        message.angle_max = math.pi - message.angle_increment
        message.range_min, message.range_max = 0.1, RANGE
        message.ranges = self.body.ranges().tolist()
        self.scans.publish(message)

    def served_map(self) -> list[int]:
        """Return the size of the map that ``map_server/map`` returns; nothing if nobody serves it."""
        client = self.create_client(GetMap, "map_server/map")
        if not client.wait_for_service(timeout_sec=1.0):
            return []
        future = client.call_async(GetMap.Request())
        rclpy.spin_until_future_complete(self, future, timeout_sec=10.0)
        return [future.result().map.info.width, future.result().map.info.height] if future.done() else []

    def target(self) -> PoseStamped:
        message = PoseStamped()
        message.header.frame_id = "map"
        message.pose.position.x, message.pose.position.y = self.goal
        message.pose.orientation.w = 1.0
        return message

    def arrived(self) -> bool:
        return bool(self.sent) and self.body.stands() and math.dist(self.body.pose[:2], self.goal) < NEAR


def main() -> None:
    """Drive to the goal once the map is there."""
    rclpy.init()
    numbers = [float(one) for one in sys.argv[2:7]]
    robot = Robot(np.load(sys.argv[1])["grid"], numbers[:3], numbers[3:])
    began = time.monotonic()
    while time.monotonic() - began < TIMEOUT and not robot.arrived():
        rclpy.spin_once(robot, timeout_sec=0.05)
        if robot.received["map"] and robot.received["cmd_vel"] == 0 and time.monotonic() - robot.sent > 5.0:
            robot.goals.publish(robot.target())  # again while nothing moves: the clone may not be localized yet
            robot.sent = time.monotonic()
    served = robot.served_map()
    sys.stdout.write(
        json.dumps(robot.received | {"pose": robot.body.pose, "nodes": robot.get_node_names(), "served": served})
    )
    rclpy.shutdown()


if __name__ == "__main__":
    main()
