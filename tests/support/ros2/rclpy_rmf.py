"""Open-RMF on rclpy with the real ``rmf_fleet_msgs``, as the adapter ``full_control`` speaks to a driver of a fleet.

``python rclpy_rmf.py FLEET ROBOT PATH LEVEL`` sends a robot along a path, ``[[X, Y, YAW], ...]``; it prints JSON.
"""

import json
import sys
import time
from typing import Any

import rclpy
from rclpy.node import Node
from rclpy.qos import qos_profile_system_default
from rmf_fleet_msgs.msg import FleetState, Location, PathRequest

TIMEOUT = 120.0
"""Longest time that a path may take [s]."""

REPEAT = 0.2
"""Time after which a request that is not confirmed is repeated [s]."""


class Adapter(Node):
    """Adapter of one fleet with one robot."""

    def __init__(self, fleet: str, robot: str, path: list[list[float]], level: str) -> None:
        super().__init__("full_control")
        places = [Location(x=x, y=y, yaw=yaw, level_name=level) for x, y, yaw in path]
        self.request = PathRequest(fleet_name=fleet, robot_name=robot, path=places, task_id="1")
        self.requests = self.create_publisher(PathRequest, "robot_path_requests", qos_profile_system_default)
        self.create_subscription(FleetState, "fleet_states", self.heard, qos_profile_system_default)
        self.states: list[Any] = []
        self.sent = 0
        self.sequence: list[int] = []

    def heard(self, message: FleetState) -> None:
        for state in message.robots:
            if (message.name, state.name) == (self.request.fleet_name, self.request.robot_name):
                self.states.append(state)
                self.sequence.append(state.seq)

    def run(self) -> dict[str, Any]:
        """Return what was seen until the path was finished."""
        remaining: list[int] = []
        began, requested = time.monotonic(), 0.0
        while time.monotonic() - began < TIMEOUT and remaining[-1:] != [0]:
            rclpy.spin_once(self, timeout_sec=0.1)
            if not self.states:
                continue
            state = self.states[-1]
            if state.task_id != self.request.task_id:
                if time.monotonic() - requested > REPEAT:
                    self.requests.publish(self.request)
                    self.sent, requested = self.sent + 1, time.monotonic()
            elif remaining[-1:] != [len(state.path)]:
                remaining.append(len(state.path))
        last = self.states[-1]
        return {
            "remaining": remaining,
            "requests": self.sent,
            "place": [last.location.x, last.location.y],
            "level": last.location.level_name,
            "mode": last.mode.mode,
            "battery": last.battery_percent,
            "in_order": self.sequence == sorted(set(self.sequence)),
        }


def main(fleet: str, robot: str, path: str, level: str) -> None:
    rclpy.init()
    adapter = Adapter(fleet, robot, json.loads(path), level)
    try:
        sys.stdout.write(json.dumps(adapter.run()))
    finally:
        adapter.destroy_node()
        rclpy.shutdown()


main(*sys.argv[1:])
