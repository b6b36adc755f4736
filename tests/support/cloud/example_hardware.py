"""Module ``hardware`` of the examples: a simulated robot in the office, in a thread; its true pose goes to the scorer.

The test copies it next to an example. The example receives only sensor data.
"""

import json
import os
import threading
import time
from pathlib import Path

from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.client.map_files import read_map_file
from robots.client.robot_file import load_robot_file
from robots.sim.world import World

EXAMPLES = Path(os.environ["EXAMPLES"])
SCORER = Path(os.environ["SCORER"])
STEP = 0.02

_lock = threading.Lock()
_world = World(read_map_file(EXAMPLES / "office.yaml"))
_robot = _world.add_robot(load_robot_file(EXAMPLES / "tb1.json").pose)


def odometry() -> tuple[float, float, float, float, float]:
    """Return the odometry: x, y, yaw, v, w."""
    with _lock:
        message = _robot.odometry()
    twist = message.twist.twist
    return (*message.pose.pose.planar(), twist.linear.x, twist.angular.z)


def scan() -> list[float | None]:
    """Return the ranges of the laser [m]."""
    with _lock:
        return _robot.scan().ranges


def drive(v: float, w: float) -> None:
    """Set the velocity of the base [m/s, rad/s]."""
    with _lock:
        _robot.command(Twist(Vector3(x=v), Vector3(z=w)))


def _live() -> None:
    begun = time.monotonic()
    while True:
        with _lock:
            while _world.time() < time.monotonic() - begun:
                _world.step()
            truth = tuple(_robot.base.pose)
        partial = SCORER.with_suffix(".partial")
        partial.write_text(json.dumps(truth))
        partial.rename(SCORER)
        time.sleep(STEP)


threading.Thread(target=_live, daemon=True).start()
