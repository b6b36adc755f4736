"""Robot written on rospy: run by the Python that has ROS 1, without this project, beside ``grid_robot.py``.

``python3 rospy_robot.py GRID.npz X Y YAW GOAL_X GOAL_Y`` drives in the cells of ``grid`` (5 cm each). It sends the goal
to ``move_base`` by actionlib and prints ``driving`` when it is on its way. Then it calls ``static_map`` and
``move_base/make_plan``, sends a goal that it cancels, and prints as JSON where it stopped and what it received.
"""

import json
import math
import sys
import time

import numpy as np
import rospy
from actionlib import SimpleActionClient
from geometry_msgs.msg import PoseStamped, TransformStamped, Twist
from grid_robot import BEAMS, RANGE, GridRobot
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import MapMetaData, OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetMap, GetPlan
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

MAPS, MOVED = 2, 0.4
"""Number of maps that are awaited, and distance after which the robot counts as driving [m]."""


class Robot:
    """Turtlebot in the cells of a map."""

    def __init__(self, grid, pose):
        self.body = GridRobot(grid, pose)
        self.received = {"cmd_vel": 0, "map": 0, "map_metadata": 0, "plan": 0, "tf": 0, "feedback": 0}
        self.odometry = rospy.Publisher("odom", Odometry, queue_size=10)
        self.scans = rospy.Publisher("scan", LaserScan, queue_size=10)
        self.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        rospy.Subscriber("cmd_vel", Twist, self.drive)
        rospy.Subscriber("/tf", TFMessage, self.heard_transforms)
        for topic, name, kind in (
            ("map", "map", OccupancyGrid),
            ("map_metadata", "map_metadata", MapMetaData),
            ("plan", "move_base/NavfnROS/plan", Path),
        ):
            rospy.Subscriber(name, kind, lambda _, topic=topic: self.count(topic))
        mount = TransformStamped(child_frame_id="base_scan")
        mount.header.frame_id, mount.transform.rotation.w = "base_link", 1.0
        self.static.publish(TFMessage([mount]))
        rospy.Timer(rospy.Duration(0.05), lambda _: self.step())
        rospy.Timer(rospy.Duration(0.1), lambda _: self.scan())

    def count(self, topic):
        self.received[topic] += 1

    def heard_transforms(self, message):
        self.received["tf"] += sum(one.child_frame_id == "odom" for one in message.transforms)

    def drive(self, twist):
        self.count("cmd_vel")
        self.body.drive(twist.linear.x, twist.angular.z)

    def step(self):
        self.odometry.publish(self.measured(*self.body.step()))

    def measured(self, speed, turn):
        message = Odometry(child_frame_id="base_link")
        message.header.stamp, message.header.frame_id = rospy.Time.now(), "odom"
        x, y, yaw = self.body.odometry()
        message.pose.pose.position.x, message.pose.pose.position.y = x, y
        message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        message.twist.twist.linear.x, message.twist.twist.angular.z = speed, turn
        return message

    def scan(self):
        message = LaserScan(angle_min=-math.pi, angle_increment=2 * math.pi / BEAMS, range_min=0.1, range_max=RANGE)
        message.header.stamp, message.header.frame_id = rospy.Time.now(), "base_scan"
        message.angle_max = math.pi - message.angle_increment
        message.ranges = self.body.ranges().tolist()
        self.scans.publish(message)


def stamped(x, y):
    pose = PoseStamped()
    pose.header.frame_id, pose.header.stamp = "map", rospy.Time.now()
    pose.pose.position.x, pose.pose.position.y, pose.pose.orientation.w = x, y, 1.0
    return pose


def wait_for(condition, seconds=60.0):
    until = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > until:
            raise TimeoutError
        time.sleep(0.05)


def drive_to(robot, move_base, goal):
    """Drive to a goal; return its final status and text. The first ones may come before the robot is localized."""
    move_base.send_goal(MoveBaseGoal(stamped(*goal)), feedback_cb=lambda _: robot.count("feedback"))
    wait_for(lambda: math.dist(robot.body.pose[:2], robot.body.start[:2]) > MOVED)
    say("driving")
    move_base.wait_for_result(rospy.Duration(90.0))
    return [move_base.get_state(), move_base.get_goal_status_text()]


def cancelled(move_base, goal):
    """Send a goal, cancel it, and return its final status."""
    move_base.send_goal(MoveBaseGoal(stamped(*goal)))
    time.sleep(1.0)
    move_base.cancel_goal()
    move_base.wait_for_result(rospy.Duration(20.0))
    return move_base.get_state()


def say(text):
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def main():
    """Drive to the goal once the map has come twice: by the first bridge, and by its successor."""
    rospy.init_node("turtlebot")
    numbers = [float(one) for one in sys.argv[2:7]]
    robot = Robot(np.load(sys.argv[1])["grid"], numbers[:3])
    wait_for(lambda: robot.received["map"])
    say("map")
    wait_for(lambda: robot.received["map"] >= MAPS)
    move_base = SimpleActionClient("move_base", MoveBaseAction)
    if not move_base.wait_for_server(rospy.Duration(20.0)):
        raise TimeoutError
    state, text = drive_to(robot, move_base, numbers[3:])
    stopped = list(robot.body.pose)
    rospy.wait_for_service("static_map", 20.0)
    grid = rospy.ServiceProxy("static_map", GetMap)().map
    plan = rospy.ServiceProxy("move_base/make_plan", GetPlan)(stamped(*numbers[3:]), stamped(*numbers[:2]), 0.2).plan
    say(
        json.dumps(
            robot.received
            | {
                "state": state,
                "text": text,
                "pose": stopped,
                "served": [grid.info.width, grid.info.height],
                "planned": len(plan.poses),
                "cancelled": cancelled(move_base, numbers[:2]),
            }
        )
    )


if __name__ == "__main__":
    main()
