"""Robot on rclpy that is sent to goals by the actions of Navigation2, as its own client; see ``rclpy_robot``.

``python rclpy_navigator.py GRID.npz X Y YAW GOAL_X GOAL_Y`` needs ``tf2_msgs`` and ``nav2_msgs``, too. It prints as
JSON how each action ended.
"""

import json
import sys
import time
from typing import Any

import numpy as np
import rclpy
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputePathToPose, ComputeRoute, FollowPath, FollowWaypoints, NavigateToPose
from nav2_msgs.srv import IsPathValid
from rclpy.action import ActionClient
from rclpy_robot import Robot
from tf2_msgs.msg import TFMessage

TIMEOUT = 150.0
"""Longest time that an action may take [s]."""


class Navigator(Robot):
    """Turtlebot whose program is a client of Navigation2."""

    def __init__(self, grid: np.ndarray, pose: list[float], goal: list[float]) -> None:
        super().__init__(grid, pose, goal)
        self.feedbacks: list[float] = []
        self.frames: set[str] = set()
        self.create_subscription(TFMessage, "tf", self.transformed, 100)

    def transformed(self, message: TFMessage) -> None:
        self.frames |= {f"{one.header.frame_id} → {one.child_frame_id}" for one in message.transforms}

    def act(self, kind: Any, name: str, goal: Any, cancel_after: float = 0.0) -> dict[str, Any]:
        """Run an action to its end, or until it is cancelled; return whether it was accepted, status and result."""
        client = ActionClient(self, kind, name)
        if not client.wait_for_server(timeout_sec=20.0):
            return {"accepted": None}
        handle = self.wait(client.send_goal_async(goal, feedback_callback=self.heard))
        if not handle.accepted:
            return {"accepted": False}
        ended = handle.get_result_async()
        if cancel_after:
            self.spin(cancel_after)
            cancelled = self.wait(handle.cancel_goal_async())
            assert len(cancelled.goals_canceling) == 1
        end = self.wait(ended)
        return {"accepted": True, "status": end.status, "code": getattr(end.result, "error_code", 0), "end": end.result}

    def is_valid(self, path: Any) -> bool:
        """Return whether the service says that a path is valid."""
        client = self.create_client(IsPathValid, "is_path_valid")
        assert client.wait_for_service(timeout_sec=20.0)
        return bool(self.wait(client.call_async(IsPathValid.Request(path=path))).is_valid)

    def heard(self, message: Any) -> None:
        self.feedbacks.append(getattr(message.feedback, "distance_remaining", 0.0))

    def wait(self, future: Any) -> Any:
        rclpy.spin_until_future_complete(self, future, timeout_sec=TIMEOUT)
        seen = f"{self.body.pose}, {len(self.feedbacks)} feedbacks, received {self.received}"
        assert future.done(), f"an action did not answer in time; the robot is at {seen}"
        return future.result()

    def spin(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self, timeout_sec=0.05)

    def at(self, x: float, y: float) -> PoseStamped:
        pose = self.target()
        pose.pose.position.x, pose.pose.position.y = x, y
        return pose


def main() -> None:
    """Run each action, and print how it ended."""
    rclpy.init()
    numbers = [float(one) for one in sys.argv[2:7]]
    robot = Navigator(np.load(sys.argv[1])["grid"], numbers[:3], numbers[3:])
    while not robot.received["map"]:
        robot.spin(0.1)
    robot.spin(2.0)  # until it is localized
    path = robot.act(ComputePathToPose, "compute_path_to_pose", ComputePathToPose.Goal(goal=robot.target()))
    reached = robot.act(NavigateToPose, "navigate_to_pose", NavigateToPose.Goal(pose=robot.target()))
    feedbacks, arrived = list(robot.feedbacks), list(robot.body.pose)
    home = robot.at(*numbers[:2])
    cancelled = robot.act(NavigateToPose, "navigate_to_pose", NavigateToPose.Goal(pose=home), cancel_after=1.5)
    wall = robot.at(0.0, 0.0)
    blocked = robot.act(NavigateToPose, "navigate_to_pose", NavigateToPose.Goal(pose=wall))
    way = robot.act(ComputePathToPose, "compute_path_to_pose", ComputePathToPose.Goal(goal=home))["end"].path
    valid = robot.is_valid(way)
    followed = robot.act(FollowPath, "follow_path", FollowPath.Goal(path=way))
    returned = list(robot.body.pose)
    route = robot.act(ComputeRoute, "compute_route", ComputeRoute.Goal(goal=home, use_poses=True))
    tour = robot.act(FollowWaypoints, "follow_waypoints", FollowWaypoints.Goal(poses=[robot.target(), wall]))
    printed = {
        "path": path | {"end": len(path["end"].path.poses)},
        "reached": reached | {"end": arrived},
        "feedbacks": len(feedbacks),
        "cancelled": cancelled | {"end": ""},
        "blocked": blocked | {"end": blocked["end"].error_msg},
        "valid": valid,
        "followed": followed | {"end": returned},
        "route": route | {"end": route["end"].error_msg},
        "tour": tour | {"end": [one.waypoint_index for one in tour["end"].missed_waypoints]},
        "frames": sorted(robot.frames),
    }
    sys.stdout.write(json.dumps(printed))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
