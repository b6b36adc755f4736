"""Node ``robot_state_publisher``."""

import math

import pytest

from ppaas.clock import Clock, ManualClock
from ppaas.errors import InvalidInput, TransformError
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.geometry_msgs import (
    Pose,
    PoseWithCovariance,
    Quaternion,
    Transform,
    TransformStamped,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from ppaas.messages.nav_msgs import Odometry
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.frames import FrameListener, FrameNames
from ppaas.nodes.graph import Graph
from ppaas.nodes.tf.state_publisher import StatePublisherNode, StatePublisherParameters
from ppaas.nodes.tf.urdf_text import UrdfText
from ppaas.robot_model.known_models import robot_model
from ppaas.transforms.planar import transform_message
from tests.support.world.other_robots import link
from tests.support.world.urdf import example


def odometry(pose: Pose2D, stamp: float, parent: str = "odom", child: str = "base_link") -> Odometry:
    header = Header(stamp=Time.of(stamp), frame_id=parent)
    return Odometry(header, child, PoseWithCovariance(Pose.of(pose)), TwistWithCovariance(Twist()))


def publisher(
    clock: Clock = lambda: 77.0, laser_frame: str = "", names: FrameNames | None = None
) -> tuple[Graph, FrameListener]:
    graph, frames = Graph(clock=clock, stamp_clock=clock), FrameListener(names)
    body, parameters = robot_model("turtlebot3_burger"), StatePublisherParameters(laser_frame)
    graph.add(lambda context: StatePublisherNode(context, body, parameters, names))
    for topic in ("tf", "tf_static"):
        graph.tap(topic, lambda topic, message: frames.hear(topic, message, clock()))
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


def without_rotation(x: float, y: float) -> Odometry:
    """Return odometry whose orientation is all zero, as ROS fills one that is left out."""
    message = odometry(Pose2D(x, y), 1.0)
    message.pose.pose.orientation = Quaternion(z=0.0, w=0.0)
    return message


@pytest.mark.parametrize(
    "wrong",
    [
        odometry(Pose2D(math.inf, 0, 0), 1.0),
        odometry(Pose2D(1e300, 0, 0), 1.0),
        odometry(Pose2D(0, -1.1e9, 0), 1.0),
        without_rotation(1.0, 2.0),
    ],
)
def test_invalid_odometry_is_refused(wrong):
    graph, frames = publisher()
    with pytest.raises(InvalidInput):
        graph.inject("odom", wrong)
    assert frames.tree.newest("base_link") is None


@pytest.mark.parametrize(
    ("names", "odom", "base"),
    [
        (None, "odom", "base_link"),
        (FrameNames.of("", "base_footprint", "map", ""), "odom", "base_footprint"),
        (FrameNames.of("odom", "base_link", "map", "r1"), "r1/odom", "r1/base_link"),
        (FrameNames.of("", "base_link", "map", "r1"), "r1/odom", "r1/base_link"),
    ],
)
@pytest.mark.parametrize("left_out", [{"parent": ""}, {"child": ""}, {"parent": "", "child": ""}])
def test_odometry_without_frames_moves_the_body_in_its_odometry_frame(names, odom, base, left_out):
    graph, frames = publisher(names=names)
    graph.inject("odom", odometry(Pose2D(1.0, 2.0, 0.3), 5.0, **{"parent": odom, "child": base} | left_out))
    assert frames.tree.lookup(odom, base, 5.0) == pytest.approx((1.0, 2.0, 0.3))
    assert frames.odometry() == pytest.approx((1.0, 2.0, 0.3))


# -- frames of the robot -----------------------------------------------------------------------------------------------


def test_latched_transforms_of_all_publishers_reach_later_subscribers():
    """As in ROS, where each publisher has a latch of its own: of the model's laser, and of two static publishers."""
    graph, _ = publisher()
    graph.inject("tf_static", TFMessage([link("base_footprint", "base_link", (0, 0, 0.1))]))
    graph.inject("tf_static", TFMessage([link("base_link", "camera"), link("base_link", "arm")]))
    graph.inject("tf_static", TFMessage([link("/base_link", "/arm", (1, 0, 0))]))
    late = FrameListener()
    graph.tap("tf_static", lambda topic, message: late.hear(topic, message, 77.0))
    assert late.tree.frames() == ("arm", "base_footprint", "base_link", "base_scan", "camera")
    assert late.tree.lookup("base_link", "arm").x == 1.0


def test_static_transforms_of_the_robot_survive_its_container():
    """A robot sends them once, and does not notice that its container was replaced."""
    first, _ = publisher()
    assert first.checkpoints() == []
    tilted = link("base_link", "laser", (0.1, 0, 0.2), (math.pi, 0, 0))
    broken = TransformStamped(Header(frame_id="a"), "b", Transform(Vector3(math.nan), Quaternion(z=0.0, w=1.0)))
    first.inject("tf_static", TFMessage([broken, tilted]))
    second, frames = publisher()
    second.restore(first.checkpoints())
    assert frames.mount("laser")[:4] == pytest.approx((0.1, 0, 0.2, 1.0))
    assert second.checkpoints() == first.checkpoints()


def test_joined_frame_is_that_of_the_odometry_until_the_robot_says_otherwise():
    graph, frames = publisher()
    graph.inject("odom", odometry(Pose2D(1.0, 0.0), 5.0, child="base_footprint"))
    assert frames.odometry() == pytest.approx((1.0, 0.0, 0.0))
    graph.inject("tf_static", TFMessage([link("base_footprint", "base_link", (0.5, 0, 0))]))
    graph.inject("odom", odometry(Pose2D(1.0, 0.0), 5.1, child="base_footprint"))
    assert frames.odometry() == pytest.approx((1.5, 0.0, 0.0))


def test_names_of_the_odometry_may_change_and_change_back():
    """A robot that is started again with other names gets the same clone for a while."""
    graph, frames = publisher()
    names = [("odom", "base_link"), ("r1/odom", "r1/base_link"), ("odom", "base_footprint")]
    for count, (parent, child) in enumerate(2 * names):
        graph.inject("odom", odometry(Pose2D(float(count), 0.0), 5.0 + count, parent, child))
        correction = transform_message("map", parent, Pose2D(0.0, 0.0), Time(5 + count))
        graph.inject("tf", TFMessage([correction]))
        assert (frames.odom, frames.odometry().x, frames.in_map().x) == (parent, count, count)
        assert frames.mount("base_scan").x == pytest.approx(-0.032)


@pytest.mark.parametrize("child", ["camera_pose_frame", "imu_link", "front_laser"])
def test_odometry_of_a_sensor_needs_its_place_on_the_robot(child):
    graph, frames = publisher(now := ManualClock(10.0))
    graph.inject("odom", odometry(Pose2D(0.0, 0.0), 10.0, child=child))  # the transform may be on its way
    now.advance(1.0)
    with pytest.raises(TransformError, match=f"moves frame '{child}', which no transform connects with 'base_link'"):
        graph.inject("odom", odometry(Pose2D(0.0, 0.0), 11.0, child=child))
    graph.inject("tf_static", TFMessage([link(child, "base_link", (-0.2, 0, 0))]))
    graph.inject("odom", odometry(Pose2D(1.0, 0.0), 11.1, child=child))
    assert frames.odometry().x == pytest.approx(0.8)


def test_sensor_is_the_base_of_a_robot_whose_file_says_so():
    graph, frames = publisher(names=FrameNames(base="camera_pose_frame"))
    graph.inject("odom", odometry(Pose2D(1.0, 0.0), 5.0, child="camera_pose_frame"))
    assert frames.odometry().x == 1.0


def test_odometry_is_not_published_while_the_robot_does_so_on_tf():
    graph, frames = publisher(now := ManualClock(10.0))
    fused = transform_message("odom_combined", "base_link", Pose2D(2.0, 0.0), Time(10))
    graph.inject("tf", TFMessage([fused]))
    graph.inject("odom", odometry(Pose2D(1.0, 0.0), 10.1))
    assert (frames.odom, frames.odometry().x) == ("odom_combined", 2.0)
    now.advance(1.1)
    graph.inject("odom", odometry(Pose2D(1.0, 0.0), 11.2))
    assert (frames.odom, frames.odometry().x) == ("odom", 1.0)


def test_another_name_of_the_map_is_a_frame():
    _, frames = publisher(names=FrameNames(map="world"))
    assert frames.tree.lookup("world", "map") == (0.0, 0.0, 0.0)


def test_names_with_a_prefix_are_those_of_ros_1():
    names = FrameNames.of("odom", "/base_footprint", "map", "/robot1/")
    assert names == FrameNames("robot1/odom", "robot1/base_footprint", "map", "robot1")
    assert FrameNames.of("", "", "", "") == FrameNames()
    assert FrameNames.of("r2/odom", "base_link", "map", "r1").odom == "r2/odom"
    assert [FrameNames(map="world").is_map(name) for name in ("", "/map", "world", "r1/map", "odom")] == [
        True, True, True, True, False,
    ]  # fmt: skip


def test_the_urdf_is_published_for_later_subscribers():
    graph, heard = Graph(), []
    body, urdf = robot_model("turtlebot2"), UrdfText.of(b"<robot/>")
    graph.add(lambda context: StatePublisherNode(context, body, StatePublisherParameters(), urdf=urdf))
    graph.tap("robot_description", lambda _, message: heard.append(message.to_message()))
    assert heard == [String("<robot/>")]


def test_a_robot_without_a_urdf_publishes_none():
    graph = publisher()[0]
    assert graph.latched("robot_description") is None


def test_transforms_that_are_refused_do_not_replace_odometry():
    clock = ManualClock(5.0)
    graph, frames = publisher(clock)
    broken = transform_message("odom", "base_link", Pose2D(float("nan"), 0.0), Time.of(5.0))
    graph.inject("tf", TFMessage([broken]))
    graph.inject("odom", odometry(Pose2D(2.0, 0.0), 5.0))
    assert frames.tree.lookup("odom", "base_link").x == 2.0


@pytest.mark.parametrize(
    "text", ["<robot name='r'/>", "<?xml version='1.0' encoding='utf-8'?>\n<robot name='Zoë'/>\r\n"]
)
def test_a_urdf_is_returned_as_it_was_stored(text: str) -> None:
    assert UrdfText.of(text.encode()).text() == text


def test_a_byte_order_mark_is_left_out() -> None:
    assert UrdfText.of(b"\xef\xbb\xbf<robot/>").to_message() == String("<robot/>")


def test_a_urdf_takes_a_part_of_its_memory() -> None:
    urdf = example("turtlebot3_waffle")
    assert len(UrdfText.of(urdf).compressed) < len(urdf) / 2
    assert UrdfText.of(urdf) == UrdfText.of(urdf)
