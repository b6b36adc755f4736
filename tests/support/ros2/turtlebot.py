"""Simulated Turtlebot that speaks ROS 2 over Zenoh."""

import asyncio
import json
from typing import Any

from ppaas.clock import monotonic
from ppaas.messages import decode, encode
from ppaas.messages.base.message import Message
from ppaas.messages.geometry_msgs import Twist
from robots.sim.driver import FixedRate
from robots.sim.robot import SimulatedRobot
from tests.support.ros2.zenoh_peer import LATCHED, SENSOR, Peer

ODOMETRY, SCAN, TF = "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan", "tf2_msgs/msg/TFMessage"
STAMPED = "geometry_msgs/msg/TwistStamped"


class Turtlebot:
    """Sensors and base of a robot as nodes of ROS 2; velocities have a header.

    Parameters
    ----------
    robot : SimulatedRobot
        The robot.
    peer : Peer
        Its node.
    """

    def __init__(self, robot: SimulatedRobot, peer: Peer) -> None:
        self._robot, self._loop = robot, asyncio.get_running_loop()
        self._odometry = peer.publisher("odom", ODOMETRY)
        self._scan = peer.publisher("scan", SCAN, SENSOR)
        self._tf = peer.publisher("tf", TF)
        self._static = peer.publisher("tf_static", TF, LATCHED)
        self.commands: list[dict[str, Any]] = []
        peer.subscribe("cmd_vel", STAMPED, lambda message: self._loop.call_soon_threadsafe(self._command, message))

    async def run(self) -> None:
        """Publish until cancelled."""
        mounted = {
            "header": {"frame_id": "base_link"},
            "child_frame_id": "laser",
            "transform": {"rotation": {"w": 1.0}},
        }
        self._static({"transforms": [mounted]})
        odom, scan = FixedRate(20.0, monotonic()), FixedRate(10.0, monotonic())
        while True:
            if odom.take(monotonic()):
                odometry = as_dict(self._robot.odometry())
                self._odometry(odometry)
                self._tf({"transforms": [_moved(odometry)]})
            if scan.take(monotonic()):
                measured = as_dict(self._robot.scan())
                measured["header"]["frame_id"] = "laser"
                self._scan(measured)
            await asyncio.sleep(max(min(odom.next, scan.next) - monotonic(), 0.0))

    def _command(self, message: dict[str, Any]) -> None:
        self.commands.append(message)
        self._robot.command(decode(Twist, json.dumps(message["twist"])))


def as_dict(message: Message) -> dict[str, Any]:
    """Return a message as a dict."""
    values: dict[str, Any] = json.loads(encode(message))
    return values


def _moved(odometry: dict[str, Any]) -> dict[str, Any]:
    pose = odometry["pose"]["pose"]
    return {
        "header": odometry["header"],
        "child_frame_id": odometry["child_frame_id"],
        "transform": {"translation": pose["position"], "rotation": pose["orientation"]},
    }
