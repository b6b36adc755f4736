"""An operator in plain roslibpy: receives map, tf, scans and commands, sends a goal, and waits for the result.

python roslibpy_operator.py 'ws://127.0.0.1:8500/?robot=tb1&role=operator' X Y     PPAAS_TOKEN is your token
"""

import os
import sys
import threading

import roslibpy

if len(sys.argv) != 4:
    sys.exit(__doc__)
url, x, y = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
ros = roslibpy.Ros(url, headers={"Authorization": f"Bearer {os.environ.get('PPAAS_TOKEN', '')}"})
ros.run(timeout=10)

heard = {name: threading.Event() for name in ("/map", "/tf", "/scan", "/cmd_vel")}
types = ("nav_msgs/OccupancyGrid", "tf2_msgs/TFMessage", "sensor_msgs/LaserScan", "geometry_msgs/Twist")
for name, kind in zip(heard, types, strict=True):
    roslibpy.Topic(ros, name, kind).subscribe(lambda _message, name=name: heard[name].set())

arrived = threading.Event()
texts = []


def on_result(message):
    texts.append((message["status"]["status"], message["status"]["text"]))
    arrived.set()


roslibpy.Topic(ros, "/move_base/result", "move_base_msgs/MoveBaseActionResult").subscribe(on_result)
goal = {
    "header": {"frame_id": "map"},
    "pose": {"position": {"x": x, "y": y, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
}
roslibpy.Topic(ros, "/move_base_simple/goal", "geometry_msgs/PoseStamped").publish(roslibpy.Message(goal))

ok = arrived.wait(120) and all(event.wait(5) for event in heard.values())
print({"heard": sorted(name for name, event in heard.items() if event.is_set()), "result": texts})
ros.terminate()
sys.exit(0 if ok and texts[0][0] == 3 else 1)
