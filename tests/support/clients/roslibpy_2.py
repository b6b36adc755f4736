"""Client in plain roslibpy 2: looks around, cancels a goal of Nav2's action, and reaches another one.

python roslibpy_2.py WS_URL '{"near": POSE, "far": POSE}'; prints what it found as one line of JSON.
"""

import json
import queue
import sys

import roslibpy

url, poses = sys.argv[1], json.loads(sys.argv[2])
ENDS = {"CANCELED": "cancelled", "SUCCEEDED": "succeeded"}


def heard_on(name, kind):
    heard = queue.Queue()
    roslibpy.Topic(ros, name, kind).subscribe(heard.put)
    return heard


def send(name):
    result, feedback = queue.Queue(), queue.Queue()
    target = {"header": {"frame_id": "map"}, "pose": poses[name]}
    goal = client.send_goal(roslibpy.Goal({"pose": target, "behavior_tree": ""}), result.put, feedback.put, result.put)
    return goal, result, feedback


def end_of(result):
    values = result.get(timeout=60)
    return ENDS.get(values["status"].name, repr(values))


ros = roslibpy.Ros(url)
ros.run(timeout=20)
grid = heard_on("/map", "nav_msgs/msg/OccupancyGrid").get(timeout=20)
pose = heard_on("/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped").get(timeout=20)
plans = heard_on("/plan", "nav_msgs/msg/Path")
client = roslibpy.ActionClient(ros, "/navigate_to_pose", "nav2_msgs/action/NavigateToPose")
goal, away, feedback = send("far")
moving = feedback.get(timeout=20)
client.cancel_goal(goal)
ends = [end_of(away)]
ends.append(end_of(send("near")[1]))
found = {
    "version": roslibpy.__version__,
    "topics": ros.get_topics(),
    "services": ros.get_services(),
    "cells": [grid["info"]["width"] * grid["info"]["height"], len(grid["data"])],
    "pose": [pose["pose"]["pose"]["position"][axis] for axis in "xy"],
    "plan": len(plans.get(timeout=20)["poses"]),
    "feedback": list(moving),
    "ends": ends,
}
sys.stdout.write(json.dumps(found))
ros.terminate()
