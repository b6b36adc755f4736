"""Requests of Open-RMF to a robot, checked, from the messages of ``rmf_fleet_msgs``."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D

MOST_WAYPOINTS = 1000
"""Largest number of waypoints of a path."""


@dataclass(frozen=True, slots=True)
class Waypoint:
    """Place of a path.

    Parameters
    ----------
    pose : Pose2D
        In the frame of Open-RMF.
    at : float
        Time at which the robot should be there, and before which it does not leave it [s].
    level : str
        Name of the level; may be empty.
    location : mapping
        The message itself, which is repeated in states.
    """

    pose: Pose2D
    at: float
    level: str
    location: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class FollowPath:
    """Follow a path in place of the one before; ``task`` is the number of the request."""

    task: str
    path: tuple[Waypoint, ...]


@dataclass(frozen=True, slots=True)
class SetMode:
    """Change the mode of the robot."""

    task: str
    mode: int


Request = FollowPath | SetMode


def path_request(message: Mapping[str, Any]) -> FollowPath:
    """Return the request of a ``PathRequest``.

    Raises
    ------
    InvalidInput
        The path is too long, or has a number that is not finite.
    """
    if len(message["path"]) > MOST_WAYPOINTS:
        raise InvalidInput(f"a path of {len(message['path'])} waypoints; at most {MOST_WAYPOINTS} are followed")
    return FollowPath(message["task_id"], tuple(map(_waypoint, message["path"])))


def destination_request(message: Mapping[str, Any]) -> FollowPath:
    """Return the request of a ``DestinationRequest``; raises as `path_request`."""
    return FollowPath(message["task_id"], (_waypoint(message["destination"]),))


def mode_request(message: Mapping[str, Any]) -> SetMode:
    """Return the request of a ``ModeRequest``."""
    return SetMode(message["task_id"], message["mode"]["mode"])


def _waypoint(location: Mapping[str, Any]) -> Waypoint:
    pose = Pose2D(*(math.nan if location[name] is None else location[name] for name in ("x", "y", "yaw")))
    if not (pose.is_finite() and pose.is_near()):
        raise InvalidInput(f"a waypoint at x {pose.x:g}, y {pose.y:g}, yaw {pose.theta:g} is nowhere")
    time = location["t"]
    return Waypoint(pose, time["sec"] + time["nanosec"] * 1e-9, location["level_name"], location)
