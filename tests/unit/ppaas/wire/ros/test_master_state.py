"""State of a master of ROS 1."""

from typing import Any

import pytest

from ppaas.errors import MalformedMessage
from ppaas.wire.ros.ros1_master import MAX_NAMES, read_state, read_types


def test_nodes_are_found_by_topic_and_service() -> None:
    state = read_state([[["/odom", ["/base", "/ekf"]]], [["/cmd_vel", ["/base"]]], [["/dock", ["/docker"]]]])
    assert state.publishers == {"/odom": {"/base", "/ekf"}}
    assert (state.subscribers, state.services) == ({"/cmd_vel": {"/base"}}, {"/dock": {"/docker"}})


def test_types_are_spelled_as_in_ros_2_and_old_names_of_one_are_known() -> None:
    types = read_types([["/odom", "nav_msgs/Odometry"], ["/tf", "tf/tfMessage"], ["/any", "*"]])
    assert types == {"/odom": "nav_msgs/msg/Odometry", "/tf": "tf2_msgs/msg/TFMessage", "/any": ""}


@pytest.mark.parametrize(
    "value",
    [
        0,
        [[], []],
        [[], [], 0],
        [[["/a"]], [], []],
        [[["/a", "/b"]], [], []],
        [[["/a", [1]]], [], []],
        [[[1, []]], [], []],
        [[["/a", []]] * (MAX_NAMES + 1), [], []],
    ],
)
def test_what_is_no_state_is_refused(value: Any) -> None:
    with pytest.raises(MalformedMessage):
        read_state(value)


@pytest.mark.parametrize("value", [0, [["/a"]], [["/a", 1]], ["/a"], [["/a", "b/C"]] * (MAX_NAMES + 1)])
def test_what_are_no_types_is_refused(value: Any) -> None:
    with pytest.raises(MalformedMessage):
        read_types(value)
