"""Node ``robot_state_publisher``."""

import math

import pytest

from ppaas.errors import InvalidInput
from ppaas.geometry import Pose2D
from ppaas.messages.geometry_msgs import Pose, PoseWithCovariance, Twist, TwistWithCovariance
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.std_msgs import Header, Time
from ppaas.nodes.frames import FrameListener
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.robot_model.known_models import robot_model


def odometry(pose: Pose2D, stamp: float, parent: str = "odom", child: str = "base_link") -> Odometry:
    header = Header(stamp=Time.of(stamp), frame_id=parent)
    return Odometry(header, child, PoseWithCovariance(Pose.of(pose)), TwistWithCovariance(Twist()))


def publisher(model: str = "turtlebot3_burger", laser_frame: str = "") -> tuple[Graph, FrameListener]:
    graph, frames = Graph(stamp_clock=lambda: 77.0), FrameListener()
    body, parameters = robot_model(model), StatePublisherParameters(laser_frame)
    graph.add(lambda context: StatePublisherNode(context, body, parameters))
    for topic in ("tf", "tf_static"):
        graph.tap(topic, lambda topic, message: frames.hear(topic, message, 77.0))
    return graph, frames


def test_laser_transform_is_known_from_the_start():
    _, frames = publisher()
    assert frames.tree.lookup("base_link", "base_scan") == pytest.approx(robot_model("turtlebot3_burger").laser)


def test_laser_frame_can_be_named_by_a_parameter():
    _, frames = publisher(laser_frame="hokuyo")
    assert "hokuyo" in frames.tree.frames()


def test_odometry_is_published_as_a_transform():
    graph, frames = publisher()
    graph.inject("odom", odometry(Pose2D(1.0, 2.0, 0.3), 5.0))
    assert frames.tree.lookup("odom", "base_link", 5.0) == pytest.approx((1.0, 2.0, 0.3))


def test_a_stamp_of_zero_means_now():
    graph, frames = publisher()
    graph.inject("odom", odometry(Pose2D(1.0, 2.0, 0.3), 0.0))
    assert frames.tree.newest("base_link") == 77.0


@pytest.mark.parametrize(
    "wrong",
    [
        odometry(Pose2D(math.inf, 0, 0), 1.0),
        odometry(Pose2D(0, 0, 0), 1.0, parent=""),
        odometry(Pose2D(0, 0, 0), 1.0, child=""),
    ],
)
def test_invalid_odometry_is_refused(wrong):
    graph, frames = publisher()
    with pytest.raises(InvalidInput):
        graph.inject("odom", wrong)
    assert frames.tree.newest("base_link") is None
