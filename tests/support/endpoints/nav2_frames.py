"""Frames of Nav2's clients over rosbridge, with the field names of ROS 2."""

from typing import Any

Json = dict[str, Any]


def stamped(x: float, y: float, frame: str = "map", z: float = 0.0, w: float = 1.0) -> Json:
    """Return a pose with the stamp of ROS 2."""
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": frame},
        "pose": {
            "position": {"x": x, "y": y, "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": z, "w": w},
        },
    }


def goal(action: str, kind: str, **args: Any) -> Json:
    """Return a goal of an action, without its operation."""
    return {"action": f"/{action}", "action_type": f"nav2_msgs/action/{kind}", "id": action, "args": args}


def seconds(duration: Json) -> float:
    """Return a duration of ROS 2 [s]."""
    assert set(duration) == {"sec", "nanosec"}
    return float(duration["sec"] + duration["nanosec"] * 1e-9)
