"""Client with the frames of ROS# for ROS 2: looks around, cancels a goal of Nav2's action, and reaches another one.

python -m tests.support.clients.ros_sharp_2 TRANSPORT WS_URL '{"near": POSE, "far": POSE}'; prints what it found as one
line of JSON.
"""

import json
import sys

from tests.support.clients.ros_sharp import RosSocket

transport, url, poses = sys.argv[1], sys.argv[2], json.loads(sys.argv[3])
ENDS = {5: "cancelled", 4: "succeeded"}


def send(name):
    target = {"header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "map"}, "pose": poses[name]}
    goal = {"pose": target, "behavior_tree": ""}
    return ros.send_action_goal("/navigate_to_pose", "nav2_msgs/action/NavigateToPose", goal)


def end_of(answers):
    while (answer := answers.get(timeout=60))["op"] != "action_result":
        pass
    return ENDS.get(answer["status"], answer) if answer["result"] else answer


ros = RosSocket(url, transport)
grid = ros.subscribe("/map", "nav_msgs/msg/OccupancyGrid").get(timeout=20)
pose = ros.subscribe("/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped").get(timeout=20)
plans = ros.subscribe("/plan", "nav_msgs/msg/Path")
away = send("far")
moving = away.get(timeout=20)
ros.cancel_action_goal("/navigate_to_pose", moving["id"])
ends = [end_of(away)]
ends.append(end_of(send("near")))
found = {
    "topics": ros.call_service("/rosapi/topics", {})["topics"],
    "services": ros.call_service("/rosapi/services", {})["services"],
    "cells": [grid["info"]["width"] * grid["info"]["height"], len(grid["data"])],
    "pose": [pose["pose"]["pose"]["position"][axis] for axis in "xy"],
    "plan": len(plans.get(timeout=20)["poses"]),
    "feedback": list(moving["values"]),
    "ends": ends,
}
sys.stdout.write(json.dumps(found))
ros.close()
