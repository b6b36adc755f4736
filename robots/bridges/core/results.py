"""Goals and results of Nav2's actions as the cloud has them, and as the releases of ROS 2 have them."""

from collections.abc import Mapping
from typing import Any

from ppaas.wire.ros.types import RosTypes

NAVIGATE, WAYPOINTS = "nav2_msgs/action/NavigateToPose", "nav2_msgs/action/FollowWaypoints"


def in_release(types: RosTypes, name: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return a message of the cloud without the fields that a type lacks in a release."""
    known = {field.name for field in types.fields(name)}
    return {key: value for key, value in values.items() if key in known}


def result_of(action: str, types: RosTypes, values: Mapping[str, Any], reason: str) -> dict[str, Any]:
    """Return the result of a goal as a release has it.

    Parameters
    ----------
    action : str
        Type of the action.
    types : RosTypes
        Types of the release.
    values : mapping
        Result of the cloud; empty if it has none.
    reason : str
        Why the goal was refused or lost; empty if it has a result.
    """
    result = dict(values)
    if reason:
        result = {"error_code": 0xFFFF, "error_msg": reason}
    if action == WAYPOINTS:
        result["missed_waypoints"] = _missed(types.release, result.get("missed_waypoints", []))
    return in_release(types, f"{action}_Result", result)


def _missed(release: str, waypoints: list[dict[str, Any]]) -> list[Any]:
    if release == "humble":
        return [one["waypoint_index"] for one in waypoints]
    if release == "jazzy":
        return [
            {"index": one["waypoint_index"], "goal": one["waypoint_pose"], "error_code": one.get("error_code", 0)}
            for one in waypoints
        ]
    return waypoints
