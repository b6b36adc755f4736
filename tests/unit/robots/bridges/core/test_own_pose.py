"""Messages of robots that localize themselves."""

import pytest

from ppaas.geometry import Pose2D
from ppaas.messages.actionlib_msgs import Status
from ppaas.messages.base.std_msgs import Time
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.nav2_motions import FollowPathError
from robots.bridges.core import own_pose

STAMP = Time(7, 5)


def test_the_frame_of_the_odometry_is_the_maps() -> None:
    pose = Pose2D(1.0, 2.0, 0.5)
    odometry = own_pose.odometry(pose, Twist(Vector3(x=0.3), Vector3(z=0.1)), STAMP)
    assert odometry.pose.pose.planar() == pytest.approx(pose)
    assert (odometry.header.frame_id, odometry.child_frame_id, odometry.twist.twist.linear.x) == (
        "odom",
        "base_link",
        0.3,
    )
    [still] = own_pose.map_to_odom(STAMP).transforms
    assert (still.header.frame_id, still.child_frame_id, still.transform.translation.x) == ("map", "odom", 0.0)
    placed = own_pose.amcl_pose(pose, 0.2, STAMP)
    assert placed.header.frame_id == "map" and placed.pose.pose.planar() == pytest.approx(pose)
    assert [placed.pose.covariance[index] for index in (0, 7, 35)] == pytest.approx([0.04] * 3)


def test_a_path_ends_with_success_or_with_its_reason() -> None:
    reached = own_pose.result("p", FollowPathError.NONE, "", STAMP)
    assert (reached.status.goal_id.id, reached.status.status) == ("p", Status.SUCCEEDED)
    lost = own_pose.result("p", FollowPathError.UNKNOWN, "it rains", STAMP)
    assert (lost.status.status, lost.result.error_msg, lost.result.error_code) == (Status.ABORTED, "it rains", 100)
    told = own_pose.feedback("p", "driving", 3.5, 0.4, STAMP)
    assert (told.status.status, told.feedback.distance_to_goal, told.feedback.speed) == (Status.ACTIVE, 3.5, 0.4)
