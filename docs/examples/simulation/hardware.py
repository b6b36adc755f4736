"""Module `hardware` for trying the examples without a robot: a simulated one in the office.

PYTHONPATH=docs/examples/simulation python docs/examples/robot.py tb1

It needs the extra sim. The programs get from it what the hardware of a robot would give them: odometry and scans.
"""

import threading
import time
from pathlib import Path

from ppaas.messages.geometry_msgs import Twist, Vector3
from robots.client.map_files import read_map_file
from robots.client.robot_file import load_robot_file
from robots.sim.world import World

EXAMPLES = Path(__file__).parents[1]
STEP = 0.02

lock = threading.Lock()
world = World(read_map_file(EXAMPLES / "office.yaml"))
robot = world.add_robot(load_robot_file(EXAMPLES / "tb1.json").pose)


def odometry() -> tuple[float, float, float, float, float]:
    """Return the odometry: x, y, yaw [m, m, rad], v, w [m/s, rad/s]."""
    with lock:
        message = robot.odometry()
    twist = message.twist.twist
    return (*message.pose.pose.planar(), twist.linear.x, twist.angular.z)


def scan() -> list[float | None]:
    """Return the ranges of the laser [m]."""
    with lock:
        return robot.scan().ranges


def drive(v: float, w: float) -> None:
    """Set the velocity of the base [m/s, rad/s]."""
    with lock:
        robot.command(Twist(Vector3(x=v), Vector3(z=w)))


def live() -> None:
    """Move the simulated robot in real time."""
    begun = time.monotonic()
    while True:
        with lock:
            while world.time() < time.monotonic() - begun:
                world.step()
        time.sleep(STEP)


threading.Thread(target=live, daemon=True).start()
