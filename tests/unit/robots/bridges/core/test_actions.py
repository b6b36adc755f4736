"""Goals and results of Nav2's actions, as the cloud and each release of ROS 2 have them."""

import msgspec
import pytest

from ppaas.geometry import Pose2D
from ppaas.messages import nav2_msgs
from ppaas.messages.base.std_msgs import Duration, Header
from ppaas.messages.codec import decode, encode
from ppaas.messages.geometry_msgs import Pose, PoseStamped
from ppaas.messages.nav2_motions import FollowPathFeedback, TrackingFeedback
from ppaas.wire.actions import part_of_action
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import ROS_2_RELEASES
from robots.bridges.core.actions import NAVIGATE, WAYPOINTS, in_release, result_of
from robots.bridges.core.tables import ACTIONS

POSE = {"header": {"frame_id": "map"}}
MISSED = [{"waypoint_status": 2, "waypoint_index": 3, "waypoint_pose": POSE, "error_code": 600, "error_msg": "blocked"}]


@pytest.mark.parametrize("release", ROS_2_RELEASES)
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
        result = result_of(action, types, values, "")
        message = {"status": 6, "result": result}
        read = types.decode(f"{action}_GetResult_Response", types.encode(f"{action}_GetResult_Response", message))
        assert read["status"] == 6
        assert release == "humble" or read["result"]["error_code"] == values["error_code"]


def test_missed_waypoints_have_their_index() -> None:
    assert result_of(WAYPOINTS, ros_types("humble"), {"missed_waypoints": MISSED}, "")["missed_waypoints"] == [3]
    [jazzy] = result_of(WAYPOINTS, ros_types("jazzy"), {"missed_waypoints": MISSED}, "")["missed_waypoints"]
    assert jazzy == {"index": 3, "goal": POSE, "error_code": 600}


def test_the_reason_of_a_lost_goal_is_in_its_result() -> None:
    assert result_of(NAVIGATE, ros_types("kilted"), {}, "connection lost")["error_msg"] == "connection lost"


@pytest.mark.parametrize("release", ROS_2_RELEASES)
def test_feedback_and_answers_have_the_fields_of_the_release(release: str) -> None:
    types = ros_types(release)
    pose = PoseStamped(Header(), Pose.of(Pose2D(1.0, 2.0)))
    for name, message in (
        (f"{NAVIGATE}_Feedback", nav2_msgs.NavigateToPoseFeedback(pose, Duration(), Duration(), 1, 2.0, 0.25, -0.5)),
        ("nav2_msgs/srv/ClearEntireCostmap_Response", nav2_msgs.ClearEntireCostmapResponse()),
    ):
        values = in_release(types, name, msgspec.json.decode(encode(message)))
        read = types.decode(name, types.encode(name, values))
        assert read.get("position_tracking_error", 0.25) == 0.25
        assert ("success" in read or "heading_tracking_error" in read) is (release == "lyrical")


@pytest.mark.parametrize("release", ROS_2_RELEASES)
def test_all_that_actions_of_the_clone_say_can_be_said_in_the_release(release: str) -> None:
    types = ros_types(release)
    for action in ACTIONS.values():
        if not types.knows(f"{action}_SendGoal"):
            continue
        for part in ("Result", "Feedback"):
            message = decode(part_of_action(action, part), b"{}")
            values = in_release(types, f"{action}_{part}", msgspec.json.decode(encode(message)))
            read = types.decode(f"{action}_{part}", types.encode(f"{action}_{part}", values))
            assert values.keys() <= read.keys()
        asked = types.decode_json(f"{action}_Goal", types.encode(f"{action}_Goal", {}))
        decode(part_of_action(action, "Goal"), asked)


def test_a_tracked_path_is_reported_as_each_release_has_it() -> None:
    tracking = TrackingFeedback(
        Header(), 0.25, -0.5, 7, PoseStamped(Header(), Pose.of(Pose2D(1.0, 2.0))), 3.0, 0.2, 4.0
    )
    told = msgspec.json.decode(encode(FollowPathFeedback(4.0, 0.2, tracking)))
    name = "nav2_msgs/action/FollowPath_Feedback"
    read = {}
    for release in ROS_2_RELEASES:
        types = ros_types(release)
        read[release] = types.decode(name, types.encode(name, in_release(types, name, told)))
    for release in ("humble", "jazzy", "kilted"):
        assert read[release] == pytest.approx({"distance_to_goal": 4.0, "speed": 0.2})
    [(key, tracked)] = read["lyrical"].items()
    assert key == "tracking_feedback"
    assert (tracked["position_tracking_error"], tracked["current_path_index"]) == (0.25, 7)
    assert tracked["robot_pose"]["pose"]["position"]["y"] == 2.0
