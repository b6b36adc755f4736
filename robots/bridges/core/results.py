"""Goals and results of Nav2's actions as the cloud has them, and as the releases of ROS 2 have them."""

from collections.abc import Mapping
from typing import Any

NAVIGATE, WAYPOINTS = "nav2_msgs/action/NavigateToPose", "nav2_msgs/action/FollowWaypoints"


def result_of(action: str, release: str, values: Mapping[str, Any], reason: str) -> dict[str, Any]:
    """Return the result of a goal as a release has it.

    Parameters
    ----------
    action : str
        Type of the action.
    release : str
        Release of ROS 2.
    values : mapping
        Result of the cloud; empty if it has none.
    reason : str
        Why the goal was refused or lost; empty if it has a result.
    """
    result = dict(values)
    if reason:
        result = {"error_code": 0xFFFF, "error_msg": reason}
    if action == WAYPOINTS:
        result["missed_waypoints"] = _missed(release, result.get("missed_waypoints", []))
    if release == "humble":
        return {key: value for key, value in result.items() if not key.startswith("error_")}
    return result


def _missed(release: str, waypoints: list[dict[str, Any]]) -> list[Any]:
    if release == "humble":
        return [one["waypoint_index"] for one in waypoints]
    if release == "jazzy":
        return [
            {"index": one["waypoint_index"], "goal": one["waypoint_pose"], "error_code": one.get("error_code", 0)}
            for one in waypoints
        ]
    return waypoints
