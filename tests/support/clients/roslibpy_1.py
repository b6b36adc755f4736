"""Client in plain roslibpy 1: looks around, cancels a goal of Move Base's action, and reaches another one.

python roslibpy_1.py WS_URL '{"near": POSE, "far": POSE}'; prints what it found as one line of JSON.
"""

import json
import queue
import sys

import roslibpy
from roslibpy.actionlib import ActionClient, Goal, GoalStatus

url, poses = sys.argv[1], json.loads(sys.argv[2])
ENDS = {GoalStatus.PREEMPTED: "cancelled", GoalStatus.SUCCEEDED: "succeeded"}


def heard_on(name, kind):
    heard = queue.Queue()
    roslibpy.Topic(ros, name, kind).subscribe(heard.put)
    return heard


def goal_at(name):
    target = {"header": {"frame_id": "map"}, "pose": poses[name]}
    return Goal(client, roslibpy.Message({"target_pose": target}))


def end_of(goal):
    goal.wait(60)
    return ENDS.get(goal.status["status"], goal.status)


ros = roslibpy.Ros(url)
ros.run(timeout=20)
grid = heard_on("/map", "nav_msgs/OccupancyGrid").get(timeout=20)
pose = heard_on("/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped").get(timeout=20)
plans = heard_on("/plan", "nav_msgs/Path")
client = ActionClient(ros, "/move_base", "move_base_msgs/MoveBaseAction")
away, feedback = goal_at("far"), queue.Queue()
away.on("feedback", feedback.put)
away.send()
moving = feedback.get(timeout=20)
away.cancel()
ends = [end_of(away)]
there = goal_at("near")
there.send()
ends.append(end_of(there))
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
client.dispose()
ros.terminate()
