"""The hardware.py of the examples: a simulated robot in the office, in a thread; where it truly is goes to the scorer.

Copied beside an example by its test, and run in the example's process. What the example is given comes from sensors.
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
    """Return what the wheels say."""
    with _lock:
        message = _robot.odometry()
    twist = message.twist.twist
    return (*message.pose.pose.planar(), twist.linear.x, twist.angular.z)


def scan() -> list[float | None]:
    """Return what the laser sees."""
    with _lock:
        return _robot.scan().ranges


def drive(v: float, w: float) -> None:
    """Drive."""
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
