"""Results of Nav2's actions in each release."""

import pytest

from ppaas.wire.ros import ros_types
from robots.bridges.core.results import NAVIGATE, WAYPOINTS, result_of

POSE = {"header": {"frame_id": "map"}}
MISSED = [{"waypoint_status": 2, "waypoint_index": 3, "waypoint_pose": POSE, "error_code": 600, "error_msg": "blocked"}]


@pytest.mark.parametrize("release", ["humble", "jazzy", "kilted"])
def test_the_clones_result_is_that_of_the_release(release: str) -> None:
    types = ros_types(release)
    for action, values in (
        (NAVIGATE, {"error_code": 9000, "error_msg": "no path"}),
        (WAYPOINTS, {"missed_waypoints": MISSED, "error_code": 603, "error_msg": "one is missed"}),
        (
            "nav2_msgs/action/ComputePathToPose",
            {"path": {}, "planning_time": {}, "error_code": 204, "error_msg": "far"},
        ),
    ):
        result = result_of(action, release, values, "")
        message = {"status": 6, "result": result}
        read = types.decode(f"{action}_GetResult_Response", types.encode(f"{action}_GetResult_Response", message))
        assert read["status"] == 6
        assert release == "humble" or read["result"]["error_code"] == values["error_code"]


def test_missed_waypoints_have_their_index() -> None:
    assert result_of(WAYPOINTS, "humble", {"missed_waypoints": MISSED}, "")["missed_waypoints"] == [3]
    [jazzy] = result_of(WAYPOINTS, "jazzy", {"missed_waypoints": MISSED}, "")["missed_waypoints"]
    assert jazzy == {"index": 3, "goal": POSE, "error_code": 600}


def test_the_reason_of_a_lost_goal_is_in_its_result() -> None:
    assert result_of(NAVIGATE, "kilted", {}, "connection lost")["error_msg"] == "connection lost"
