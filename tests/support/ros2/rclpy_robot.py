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
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetMap
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

RESOLUTION, RANGE, BEAMS = 0.05, 8.0, 360
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
TIMEOUT, NEAR = 70.0, 0.3


class Robot(Node):
    """Turtlebot that turns and drives as it is told, without errors of its odometry."""

    def __init__(self, grid: np.ndarray, pose: list[float], goal: list[float]) -> None:
        super().__init__("turtlebot")
        self.grid, self.start, self.pose, self.goal = grid, tuple(pose), list(pose), goal
        self.command, self.commanded, self.stepped = (0.0, 0.0), 0.0, time.monotonic()
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
        self.angles = np.linspace(-math.pi, math.pi, BEAMS, endpoint=False)
        self.distances = np.arange(0.1, RANGE, RESOLUTION / 2)

    def count(self, topic: str) -> None:
        self.received[topic] += 1

    def drive(self, twist: Twist) -> None:
        self.count("cmd_vel")
        self.command, self.commanded = (twist.linear.x, twist.angular.z), time.monotonic()

    def step(self) -> None:
        now = time.monotonic()
        passed, self.stepped = now - self.stepped, now
        speed, turn = self.command if now - self.commanded < 0.5 else (0.0, 0.0)
        x, y, yaw = self.pose
        yaw += turn * passed
        self.pose = [x + speed * math.cos(yaw) * passed, y + speed * math.sin(yaw) * passed, yaw]
        self.odometry.publish(self.measured(speed, turn))

    def measured(self, speed: float, turn: float) -> Odometry:
        message = Odometry()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id, message.child_frame_id = "odom", "base_link"
        x, y = self.pose[0] - self.start[0], self.pose[1] - self.start[1]
        cosine, sine = math.cos(self.start[2]), math.sin(self.start[2])
        message.pose.pose.position.x, message.pose.pose.position.y = cosine * x + sine * y, cosine * y - sine * x
        half = (self.pose[2] - self.start[2]) / 2
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(half), math.cos(half)
        message.twist.twist.linear.x, message.twist.twist.angular.z = speed, turn
        return message

    def scan(self) -> None:
        angles = self.angles + self.pose[2]
        columns = (self.pose[0] + np.outer(np.cos(angles), self.distances)) / RESOLUTION
        rows = (self.pose[1] + np.outer(np.sin(angles), self.distances)) / RESOLUTION
        height, width = self.grid.shape
        hit = self.grid[rows.astype(int).clip(0, height - 1), columns.astype(int).clip(0, width - 1)] > 50
        message = LaserScan()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = "base_link"
        message.angle_min, message.angle_increment = -math.pi, 2 * math.pi / BEAMS
        message.angle_max = math.pi - message.angle_increment
        message.range_min, message.range_max = 0.1, RANGE
        message.ranges = np.where(hit.any(1), self.distances[hit.argmax(1)], np.inf).astype(np.float32).tolist()
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
        stopped = time.monotonic() - self.commanded > 1.0
        return bool(self.sent) and stopped and math.dist(self.pose[:2], self.goal) < NEAR


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
        json.dumps(robot.received | {"pose": robot.pose, "nodes": robot.get_node_names(), "served": served})
    )
    rclpy.shutdown()


if __name__ == "__main__":
    main()
