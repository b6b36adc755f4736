"""A robot of another make that takes part in seeing people, in plain roslibpy; it does not need PPaaS installed.

python people_robot.py 'ws://127.0.0.1:8500/?robot=guide'     PPAAS_TOKEN is your token

The robot knows where it is and detects people by itself. Here both are made up: replace ``pose`` and ``people``.
"""

import math
import os
import sys
import time

import roslibpy

VARIANCE = 0.01  # of the robot's x and y [m²]; the heading's is as large [rad²]


def pose():
    """Return where the robot is in the map: x, y [m], yaw [rad]."""
    return 2.0, 2.0, 0.0


def people():
    """Return the people that the robot sees: id, x ahead and y to the left of it [m]."""
    angle = 0.5 * time.time()
    return [("1", 2.0, 0.3 * math.sin(angle)), ("2", 3.0, 1.0)]


if len(sys.argv) != 2:
    sys.exit(__doc__)
ros = roslibpy.Ros(sys.argv[1], headers={"Authorization": f"Bearer {os.environ.get('PPAAS_TOKEN', '')}"})
ros.run(timeout=10)
localized = roslibpy.Topic(ros, "/amcl_pose", "geometry_msgs/PoseWithCovarianceStamped")
seen = roslibpy.Topic(ros, "/people", "people_msgs/People")
for topic in (localized, seen):
    topic.advertise()


def on_state(state):
    followed = ", ".join(f"{order['robot']} follows {order['person']}" for order in state["orders"])
    print(f"{state['count']} people on the map{': ' + followed if followed else ''}", flush=True)


coordinator = roslibpy.Topic(ros, "/people_coordinator/state", "ppaas_msgs/PeopleState", throttle_rate=1000)
coordinator.subscribe(on_state)

while ros.is_connected:
    now = time.time()
    stamp = {"secs": int(now), "nsecs": int(now % 1.0 * 1e9)}
    x, y, yaw = pose()
    orientation = {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
    covariance = [VARIANCE if k in (0, 7, 35) else 0.0 for k in range(36)]
    where = {"pose": {"position": {"x": x, "y": y, "z": 0.0}, "orientation": orientation}, "covariance": covariance}
    localized.publish({"header": {"stamp": stamp, "frame_id": "map"}, "pose": where})
    found = [
        {
            "name": name,
            "position": {"x": ahead, "y": left, "z": 0.0},
            "velocity": {"x": 0.0, "y": 0.0, "z": 0.0},
            "reliability": 0.9,
            "tagnames": [],
            "tags": [],
        }
        for name, ahead, left in people()
    ]
    seen.publish({"header": {"stamp": stamp, "frame_id": "base_link"}, "people": found})
    time.sleep(0.2)
