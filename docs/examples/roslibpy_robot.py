"""A complete robot in plain roslibpy; it does not need PPaaS installed.

python roslibpy_robot.py 'ws://127.0.0.1:8500/?robot=tb1'     PPAAS_TOKEN is your token, and you write hardware.py
"""

import math
import os
import sys
import time

import hardware
import roslibpy

ros = roslibpy.Ros(sys.argv[1], headers={"Authorization": f"Bearer {os.environ.get('PPAAS_TOKEN', '')}"})
ros.run(timeout=10)
command = {"v": 0.0, "w": 0.0, "received": 0.0}


def on_cmd_vel(twist):
    command.update(v=twist["linear"]["x"], w=twist["angular"]["z"], received=time.monotonic())


roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/Twist").subscribe(on_cmd_vel)
odom = roslibpy.Topic(ros, "/odom", "nav_msgs/Odometry")
scan = roslibpy.Topic(ros, "/scan", "sensor_msgs/LaserScan")
for topic in (odom, scan):
    topic.advertise()

while ros.is_connected:
    x, y, yaw, v, w = hardware.odometry()
    orientation = {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    odom.publish(
        {
            "header": {"frame_id": "odom"},
            "child_frame_id": "base_link",
            "pose": {"pose": {"position": {"x": x, "y": y, "z": 0.0}, "orientation": orientation}},
            "twist": {"twist": {"linear": {"x": v, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": w}}},
        }
    )
    scan.publish(
        {
            "header": {"frame_id": "base_link"},
            "angle_min": -math.pi,
            "angle_max": math.pi,
            "angle_increment": math.pi / 180,
            "range_min": 0.12,
            "range_max": 8.0,
            "ranges": hardware.scan(),
        }
    )
    fresh = time.monotonic() - command["received"] < 0.5  # without the cloud, the robot must stop
    hardware.drive(command["v"] if fresh else 0.0, command["w"] if fresh else 0.0)
    time.sleep(0.1)
