"""The page for robots with ROS 1 lists what the bridge carries."""

import pytest

from ppaas.wire.ros import ros_types
from robots.bridges.core.tables import UpTopic
from robots.bridges.ros1.move_base import MOVE_BASE, ROS_1
from tests.support.documents import text_of

PAGE = text_of("docs/ros1.md")

NOT_OF_ROS_1 = {"goal_update"}
"""Topics of Nav2 that a robot with ROS 1 may have, and that the page leaves out."""


@pytest.mark.parametrize("name", [*(one.name for one in ROS_1.down), *(one.name for one in ROS_1.services), MOVE_BASE])
def test_what_goes_to_the_robot_is_listed(name: str) -> None:
    assert f"`{name}`" in PAGE


@pytest.mark.parametrize("topic", [one for one in ROS_1.up if one.cloud not in NOT_OF_ROS_1], ids=lambda one: one.cloud)
def test_what_goes_to_the_cloud_is_listed(topic: UpTopic) -> None:
    short = topic.names[0].removeprefix("camera/depth/").removeprefix("image_raw")
    assert f"`{topic.names[0]}`" in PAGE or f"`{short}`" in PAGE


def test_all_types_are_those_of_noetic() -> None:
    types = ros_types("noetic")
    assert all(types.knows(one.type) for one in (*ROS_1.up, *ROS_1.down, *ROS_1.services))
    assert types.md5("octomap_msgs/Octomap") == "9a45536b45c5e409cd49f04bb2d9999f"
