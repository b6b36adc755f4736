"""Client in plain roslibpy 2: looks around, cancels a goal of Nav2's action, follows a path, and reaches a goal.

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


def at(name):
    return {"header": {"frame_id": "map"}, "pose": poses[name]}


def send(name):
    return act(client, {"pose": at(name), "behavior_tree": ""})


def act(action, values):
    result, feedback = queue.Queue(), queue.Queue()
    goal = action.send_goal(roslibpy.Goal(values), result.put, feedback.put, result.put)
    return goal, result, feedback


def action_of(name, kind):
    return roslibpy.ActionClient(ros, name, f"nav2_msgs/action/{kind}")


def follow_path_to(name):
    """Return how FollowPath along a planned path ended, and the names in its feedback."""
    planned = act(action_of("/compute_path_to_pose", "ComputePathToPose"), {"goal": at(name)})[1].get(timeout=20)
    followed = act(action_of("/follow_path", "FollowPath"), {"path": planned["values"]["path"]})
    return end_of(followed[1]), sorted(followed[2].get(timeout=20))


def end_of(result):
    values = result.get(timeout=60)
    return ENDS.get(values["status"].name, repr(values))


ros = roslibpy.Ros(url)
ros.run(timeout=20)
grid = heard_on("/map", "nav_msgs/msg/OccupancyGrid").get(timeout=20)
pose = heard_on("/amcl_pose", "geometry_msgs/msg/PoseWithCovarianceStamped").get(timeout=20)
plans = heard_on("/plan", "nav_msgs/msg/Path")
client = action_of("/navigate_to_pose", "NavigateToPose")
goal, away, feedback = send("far")
moving = feedback.get(timeout=20)
client.cancel_goal(goal)
ends = [end_of(away)]
followed = follow_path_to("far")
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
    "followed": followed,
}
sys.stdout.write(json.dumps(found))
ros.terminate()
