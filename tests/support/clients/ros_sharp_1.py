"""Client with the frames of ROS# for ROS 1: looks around, cancels a goal of Move Base's action, reaches another one.

python -m tests.support.clients.ros_sharp_1 TRANSPORT WS_URL '{"near": POSE, "far": POSE}'; prints what it found as one
line of JSON.
"""

import json
import sys
import uuid

from tests.support.clients.ros_sharp import RosSocket

transport, url, poses = sys.argv[1], sys.argv[2], json.loads(sys.argv[3])
ENDS = {2: "cancelled", 3: "succeeded"}
NEVER = {"secs": 0, "nsecs": 0}
STEP = 200
"""``timeStep`` of ROS#'s action clients [ms]: the throttle rate of status, feedback and result."""


def send(name):
    goal_id = {"stamp": NEVER, "id": f"{name}-{uuid.uuid4()}"}
    target = {"header": {"seq": 0, "stamp": NEVER, "frame_id": "map"}, "pose": poses[name]}
    header = {"seq": 0, "stamp": NEVER, "frame_id": ""}
    ros.publish(goal_publication, {"header": header, "goal_id": goal_id, "goal": {"target_pose": target}})
    return goal_id


def end_of(goal_id):
    while (result := results.get(timeout=60)["status"])["goal_id"]["id"] != goal_id["id"]:
        pass
    return ENDS.get(result["status"], result)


ros = RosSocket(url, transport)
grid = ros.subscribe("/map", "nav_msgs/OccupancyGrid").get(timeout=20)
pose = ros.subscribe("/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped").get(timeout=20)
plans = ros.subscribe("/plan", "nav_msgs/Path")
cancel_publication = ros.advertise("move_base/cancel", "actionlib_msgs/GoalID")
goal_publication = ros.advertise("move_base/goal", "move_base_msgs/MoveBaseActionGoal")
statuses = ros.subscribe("move_base/status", "actionlib_msgs/GoalStatusArray", STEP)
feedback = ros.subscribe("move_base/feedback", "move_base_msgs/MoveBaseActionFeedback", STEP)
results = ros.subscribe("move_base/result", "move_base_msgs/MoveBaseActionResult", STEP)
statuses.get(timeout=20)
away = send("far")
moving = feedback.get(timeout=20)["feedback"]
ros.publish(cancel_publication, away)
ends = [end_of(away)]
ends.append(end_of(send("near")))
found = {
    "topics": ros.call_service("/rosapi/topics", {})["topics"],
    "services": ros.call_service("/rosapi/services", {})["services"],
    "cells": [grid["info"]["width"] * grid["info"]["height"], len(grid["data"])],
    "pose": [pose["pose"]["pose"]["position"][axis] for axis in "xy"],
    "plan": len(plans.get(timeout=20)["poses"]),
    "feedback": list(moving),
    "ends": ends,
}
sys.stdout.write(json.dumps(found))
ros.close()
