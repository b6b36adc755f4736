"""Actions and services of Nav2 in each release, as its packages define them."""

import pytest

from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import ROS_2_RELEASES
from robots.bridges.core.tables import ACTIONS, OTHER_PACKAGES, SERVICES

FIELDS = {
    "nav2_msgs/action/FollowPath_Feedback": {
        "humble": "distance_to_goal speed",
        "kilted": "distance_to_goal speed",
        "lyrical": "tracking_feedback",
    },
    "nav2_msgs/action/FollowPath_Goal": {
        "humble": "path controller_id goal_checker_id",
        "jazzy": "path controller_id goal_checker_id progress_checker_id",
        "lyrical": "path controller_id goal_checker_id progress_checker_id path_handler_id",
    },
    "nav2_msgs/action/Spin_Goal": {
        "jazzy": "target_yaw time_allowance",
        "kilted": "target_yaw time_allowance disable_collision_checks",
    },
    "nav2_msgs/action/BackUp_Result": {
        "humble": "total_elapsed_time",
        "jazzy": "total_elapsed_time error_code error_msg",
    },
    "nav2_msgs/action/ComputeRoute_Result": {
        "humble": "planning_time path route",
        "jazzy": "planning_time path route error_code",
        "kilted": "planning_time path route error_code error_msg",
    },
    "nav2_msgs/action/ComputePathThroughPoses_Result": {
        "kilted": "path planning_time error_code error_msg",
        "lyrical": "path last_reached_index planning_time error_code error_msg",
    },
    "nav2_msgs/action/NavigateThroughPoses_Result": {
        "humble": "result",
        "jazzy": "error_code error_msg",
        "kilted": "error_code error_msg waypoint_statuses",
    },
    "nav2_msgs/srv/IsPathValid_Request": {
        "jazzy": "path",
        "kilted": "path max_cost consider_unknown_as_obstacle",
        "lyrical": "path max_cost consider_unknown_as_obstacle layer_name footprint stop_at_first_collision "
        "max_lookahead_distance",
    },
}


@pytest.mark.parametrize("name", FIELDS)
def test_each_release_has_its_fields(name: str) -> None:
    for release, fields in FIELDS[name].items():
        assert [each.name for each in ros_types(release).fields(name)] == fields.split(), release


@pytest.mark.parametrize("release", ROS_2_RELEASES)
def test_each_release_has_all_that_the_bridge_offers(release: str) -> None:
    types = ros_types(release)
    kinds = {name: (kind, OTHER_PACKAGES.get(kind, kind)) for name, kind in ACTIONS.items()}
    lacking = {name for name, both in kinds.items() if not any(types.knows(f"{kind}_SendGoal") for kind in both)}
    assert lacking == (set() if release == "lyrical" else {"follow_object"})
    assert all(types.knows(service.type) for service in SERVICES)


def test_docks_are_in_another_package_in_humble() -> None:
    results = {
        release: [each.name for each in ros_types(release).fields(f"{package}/action/DockRobot_Result")]
        for release, package in (("humble", "opennav_docking_msgs"), ("jazzy", "nav2_msgs"), ("lyrical", "nav2_msgs"))
    }
    coded = ["success", "error_code", "num_retries"]
    assert results == {"humble": coded, "jazzy": [*coded, "error_msg"], "lyrical": [*coded, "error_msg"]}
    assert [ros_types(each).knows("nav2_msgs/action/DockRobot_Goal") for each in ("humble", "jazzy")] == [False, True]


def test_poses_are_goals_since_kilted() -> None:
    kinds = {
        release: ros_types(release).fields("nav2_msgs/action/NavigateThroughPoses_Goal")[0].type
        for release in ROS_2_RELEASES
    }
    assert kinds == dict.fromkeys(("humble", "jazzy"), "geometry_msgs/msg/PoseStamped") | dict.fromkeys(
        ("kilted", "lyrical"), "nav_msgs/msg/Goals"
    )
