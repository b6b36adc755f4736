"""Operator in plain roslibpy: queries rosapi, drives the robot by topic and by action, and advertises a service.

python roslibpy_operator.py WS_URL '{"near": POSE, "far": POSE, "back": POSE}'; prints its results as one line of
JSON. It runs in its own process, because roslibpy's reactor can be started only once per process.
"""

import json
import queue
import sys

import roslibpy
from roslibpy.ros1.actionlib import ActionClient as Ros1ActionClient
from roslibpy.ros1.actionlib import Goal as Ros1Goal
from roslibpy.tf import TFClient

url, given = sys.argv[1], json.loads(sys.argv[2])
found = {}


def connect():
    ros = roslibpy.Ros(url)
    ros.run(timeout=20)
    return ros


def stamped(name):
    return {"header": {"frame_id": "map"}, "pose": given[name]}


def subscribed(topic):
    heard = queue.Queue()
    topic.subscribe(heard.put)
    return heard


def next_of(ros, name, kind, **options):
    topic = roslibpy.Topic(ros, name, kind, **options)
    message = subscribed(topic).get(timeout=20)
    topic.unsubscribe()
    return message


def look_around(ros):
    found["topics"] = ros.get_topics()
    found["mapType"] = ros.get_topic_type("/map")
    found["services"] = ros.get_services()
    found["actions"] = asked(ros.get_action_servers)["action_servers"]
    found["frequency"] = ros.get_param("/move_base/controller_frequency")
    found["nodes"] = ros.get_nodes()
    found["year"] = ros.get_time().secs
    grid = next_of(ros, "/map", "nav_msgs/OccupancyGrid", compression="png")
    found["cells"] = [grid["info"]["width"] * grid["info"]["height"], len(grid["data"])]
    pose = "geometry_msgs/{}PoseWithCovarianceStamped"
    found["ros1Stamp"] = list(next_of(ros, "/amcl_pose", pose.format(""))["header"]["stamp"])
    found["ros2Stamp"] = list(next_of(ros, "/amcl_pose", pose.format("msg/"))["header"]["stamp"])


def asked(call):
    answers = queue.Queue()
    call(answers.put, answers.put)
    return answers.get(timeout=20)


def drive_by_topic(ros):
    results = subscribed(roslibpy.Topic(ros, "/move_base/result", "move_base_msgs/MoveBaseActionResult"))
    roslibpy.Topic(ros, "/move_base_simple/goal", "geometry_msgs/PoseStamped").publish(
        roslibpy.Message(stamped("near"))
    )
    found["byTopic"] = results.get(timeout=60)["status"]["status"]


def drive_by_action_of_ros1(ros):
    client = Ros1ActionClient(ros, "/move_base", "move_base_msgs/MoveBaseAction")
    goal = Ros1Goal(client, roslibpy.Message({"target_pose": stamped("back")}))
    goal.send()
    goal.wait(60)
    found["ros1Feedback"] = list(goal.feedback)
    away = Ros1Goal(client, roslibpy.Message({"target_pose": stamped("far")}))
    moving = queue.Queue()
    away.on("feedback", moving.put)
    away.send()
    moving.get(timeout=20)
    away.cancel()
    away.wait(20)
    found["ros1Ends"] = [goal.status["status"], away.status["status"]]
    client.dispose()


def drive_by_action_of_ros2(ros):
    client = roslibpy.ActionClient(ros, "/navigate_to_pose", "nav2_msgs/action/NavigateToPose")
    told = {"result": queue.Queue(), "feedback": queue.Queue(), "failed": queue.Queue()}
    callbacks = [told[name].put for name in ("result", "feedback", "failed")]
    goal = client.send_goal(roslibpy.Goal({"pose": stamped("far"), "behavior_tree": ""}), *callbacks)
    found["ros2Feedback"] = list(told["feedback"].get(timeout=20))
    client.cancel_goal(goal)
    cancelled = told["result"].get(timeout=20)
    found["ros2Cancelled"] = [cancelled["status"].name, cancelled["values"]["error_msg"]]
    moon = {"header": {"frame_id": "moon"}, "pose": given["far"]}
    client.send_goal(roslibpy.Goal({"pose": moon}), *callbacks)
    refused = told["failed"].get(timeout=20)
    found["ros2Refused"] = [refused["status"].name, refused["values"]]


def serve(ros, other):
    plan = roslibpy.Service(ros, "/move_base/make_plan", "nav_msgs/GetPlan")
    request = {"start": {"header": {}, "pose": given["near"]}, "goal": stamped("far"), "tolerance": 0.2}
    found["poses"] = len(plan.call(roslibpy.ServiceRequest(request), timeout=20)["plan"]["poses"])

    def switch(request, response):
        response.update({"success": request["data"], "message": "on" if request["data"] else "broken"})
        return bool(request["data"])

    roslibpy.Service(ros, "/lamp", "std_srvs/SetBool").advertise(switch)
    lamp = roslibpy.Service(other, "/lamp", "std_srvs/SetBool")
    while "/lamp" not in other.get_services():
        pass
    found["lamp"] = dict(lamp.call(roslibpy.ServiceRequest({"data": True}), timeout=20))
    found["broken"] = asked(
        lambda ok, no: lamp.call(roslibpy.ServiceRequest({"data": False}), ok, lambda e: no({"no": e}))
    )


def talk(ros, other):
    heard = subscribed(roslibpy.Topic(other, "/gossip", "std_msgs/String"))
    roslibpy.Topic(ros, "/gossip", "std_msgs/String", latch=True).publish(roslibpy.Message({"data": "hello"}))
    found["gossip"] = [heard.get(timeout=20)["data"], next_of(other, "/gossip", "std_msgs/String")["data"]]


def look_at_frames(ros):
    frames = queue.Queue()
    client = TFClient(ros, fixed_frame="/map", angular_threshold=0.01, translation_threshold=0.01)
    client.subscribe("/base_link", frames.put)
    found["frame"] = list(frames.get(timeout=20))
    client.dispose()


first, second = connect(), connect()
look_around(first)
drive_by_topic(first)
look_at_frames(first)
drive_by_action_of_ros1(first)
drive_by_action_of_ros2(first)
serve(first, second)
talk(first, second)
sys.stdout.write(json.dumps(found))
second.close()
first.terminate()
