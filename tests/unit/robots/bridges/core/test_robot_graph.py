"""One robot in a graph: its namespace and its topics."""

import json
from typing import Any

import pytest

from ppaas.errors import NotFound
from ppaas.messages import decode
from ppaas.nodes.topics import TOPICS
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import LATCHED, Entity, Kind, Qos
from robots.bridges.core.frames import HOLD, Frames
from robots.bridges.core.robot_graph import TF_MESSAGE, TWIST, TWIST_STAMPED, RobotGraph, find_namespace
from robots.bridges.core.tables import DOWN, ODOMETRY, PARTICLES, SCAN, SERVICES, UP, DownTopic, UpTopic


def publisher(name: str, type_name: str, qos: Qos | None = None, kind: Kind = Kind.PUBLISHER) -> Entity:
    return Entity(kind, name, type_name, qos or Qos(), "/node", name + type_name)


def base(name: str, type_name: str = TWIST) -> Entity:
    return publisher(name, type_name, kind=Kind.SUBSCRIBER)


def test_the_namespace_is_that_of_the_odometry_or_the_scan() -> None:
    assert find_namespace([publisher("/tb3_1/odom", ODOMETRY.type)], "any") == "/tb3_1"
    assert find_namespace([publisher("/fleet/a/scan", SCAN.type)], "any") == "/fleet/a"
    assert find_namespace([publisher("/odom", ODOMETRY.type), publisher("/scan", SCAN.type)], "any") == ""
    assert find_namespace([publisher("/odometry/filtered", ODOMETRY.type)], "any") == ""
    assert find_namespace([base("/cmd_vel")], "any") is None


def test_of_several_robots_the_one_of_that_name_is_taken() -> None:
    robots = [publisher("/tb3_1/odom", ODOMETRY.type), publisher("/tb3_2/odom", ODOMETRY.type)]
    assert find_namespace(robots, "tb3-2") == "/tb3_2"
    with pytest.raises(NotFound, match="known: /tb3_1, /tb3_2"):
        find_namespace(robots, "carl")


def test_a_topic_is_found_by_its_name_or_by_its_type() -> None:
    graph = RobotGraph([publisher("/a/odom", ODOMETRY.type), publisher("/b/odom", ODOMETRY.type)], "/b")
    source = graph.source(ODOMETRY)
    assert source is not None
    assert source.topic == "/b/odom"
    only = RobotGraph([publisher("/b/diff_drive/odom", ODOMETRY.type)], "/b").source(ODOMETRY)
    assert only is not None
    assert only.topic == "/b/diff_drive/odom"
    two = [publisher("/b/front_scan", SCAN.type), publisher("/b/rear_scan", SCAN.type)]
    assert RobotGraph(two, "/b").source(SCAN) is None, "which one is not for the bridge to guess"


def test_transforms_are_those_of_the_namespace_or_of_the_root() -> None:
    static = publisher("/tf_static", TF_MESSAGE, LATCHED)
    source = RobotGraph([static], "/a").transforms("tf_static")
    assert source is not None
    assert (source.topic, source.latched) == ("/tf_static", True)
    own = publisher("/a/tf_static", TF_MESSAGE)
    both = RobotGraph([static, own], "/a").transforms("tf_static")
    assert both is not None
    assert (both.topic, both.latched) == ("/a/tf_static", False)
    assert RobotGraph([], "/a").tf_topic() == "/a/tf"
    assert RobotGraph([publisher("/tf", TF_MESSAGE)], "/a").tf_topic() == "/tf"
    listener = Entity(Kind.SUBSCRIBER, "/tf", TF_MESSAGE, Qos(), "/viewer", "1")
    assert RobotGraph([listener], "/a").tf_topic() == "/tf", "as nodes of ROS 1 have it, whatever their namespace"
    own = Entity(Kind.SUBSCRIBER, "/a/tf", TF_MESSAGE, Qos(), "/viewer", "2")
    assert RobotGraph([listener, own], "/a").tf_topic() == "/a/tf"


def test_velocities_go_where_a_base_expects_them_with_its_type() -> None:
    others = [base("/b/cmd_vel"), publisher("/a/cmd_vel", TWIST)]
    assert RobotGraph([*others, base("/a/cmd_vel", TWIST_STAMPED)], "/a").velocity_topics() == {
        "/a/cmd_vel": {TWIST_STAMPED}
    }
    controller = "/a/diff_drive_controller/cmd_vel"
    assert RobotGraph([*others, base(controller)], "/a").velocity_topics() == {controller: {TWIST}}
    assert RobotGraph(others, "/a").velocity_topics() == {}


@pytest.mark.parametrize("untyped", ["", "*"])
def test_velocities_go_through_a_mux_that_subscribes_without_a_type(untyped: str) -> None:
    """``topic_tools mux``, relay and throttle: the base behind them must hear nobody but them."""
    behind = base("/a/base/cmd_vel")
    mux = [base("/a/cmd_vel", untyped), base("/a/joy_vel", untyped), behind]
    assert RobotGraph(mux, "/a").velocity_topics() == {"/a/cmd_vel": {TWIST}}
    assert RobotGraph([base("/b/cmd_vel", untyped), behind], "/a").velocity_topics() == {"/a/base/cmd_vel": {TWIST}}
    stamped = [*mux, base("/a/cmd_vel", TWIST_STAMPED)]
    assert RobotGraph(stamped, "/a").velocity_topics() == {"/a/cmd_vel": {TWIST_STAMPED}}


def test_velocities_go_past_nobody_who_expects_another_type_at_cmd_vel() -> None:
    ackermann = [base("/a/cmd_vel", "ackermann_msgs/msg/AckermannDriveStamped"), base("/a/base/cmd_vel")]
    assert RobotGraph(ackermann, "/a").velocity_topics() == {}


RELEASES = ("humble", "jazzy", "kilted")


@pytest.mark.parametrize("release", RELEASES)
def test_each_release_knows_the_types(release: str) -> None:
    types = ros_types(release)
    assert [topic.cloud for topic in (*UP, *DOWN) if topic.type not in types] == []
    assert [service.name for service in SERVICES if not types.knows(service.type)] == []


@pytest.mark.parametrize("topic", [one for one in UP if one.clone], ids=lambda topic: topic.cloud)
def test_the_clone_reads_what_the_robot_publishes(topic: UpTopic) -> None:
    types = ros_types("jazzy")
    text = types.decode_json(topic.type, types.encode(topic.type, {}))
    assert decode(TOPICS[topic.cloud].type, text) is not None


@pytest.mark.parametrize("topic", [one for one in DOWN if one is not PARTICLES], ids=lambda topic: topic.cloud)
def test_the_robot_reads_what_the_clone_publishes(topic: DownTopic) -> None:
    types = ros_types("jazzy")
    empty = types.decode_json(topic.type, types.encode(topic.type, {}))
    fields = json.loads(empty).keys()
    assert TOPICS[topic.cloud].type.__struct_fields__ == tuple(fields)


def transform(parent: str, child: str, x: float = 0.0) -> dict[str, Any]:
    return {"header": {"frame_id": parent}, "child_frame_id": child, "transform": {"translation": {"x": x}}}


def test_scans_wait_for_their_frame_but_not_for_ever() -> None:
    frames = Frames()
    frames.odometry({"header": {"frame_id": "odom"}, "child_frame_id": "base_footprint"})
    assert frames.may_send_scan("base_footprint", 0.0)
    assert frames.may_send_scan("", 0.0)
    assert not frames.may_send_scan("laser", 0.0)
    assert not frames.may_send_scan("laser", HOLD)
    assert frames.may_send_scan("laser", HOLD + 0.1), "the cloud may know it from the robot's model"
    other = Frames()
    assert not other.may_send_scan("laser", 0.0)
    other.sent([transform("base_link", "/laser")])
    assert other.may_send_scan("laser", 0.0)


def test_the_cloud_gets_the_parts_of_the_robot_and_not_what_it_knows_by_odometry() -> None:
    frames = Frames()
    all_of_them = [transform("odom", "base_link"), transform("map", "odom"), transform("base_link", "laser")]
    assert frames.upward(all_of_them, 0.0, static=False) == [all_of_them[2]]


def test_a_transform_that_has_not_changed_is_sent_once_a_second() -> None:
    frames = Frames()
    still, moved = [transform("base_link", "wheel")], [transform("base_link", "wheel", 0.1)]
    sent = [bool(frames.upward(still, now, static=False)) for now in (0.0, 0.5, 0.9, 1.0, 1.5)]
    assert sent == [True, False, False, True, False]
    assert frames.upward(moved, 1.6, static=False)
    assert frames.upward(still, 1.6, static=True), "what is published once is sent each time"


def test_the_robot_gets_the_place_of_its_odometry_in_the_map_alone() -> None:
    frames = Frames()
    frames.odometry({"header": {"frame_id": "tb3/odom"}, "child_frame_id": "tb3/base_link"})
    wanted = transform("map", "tb3/odom")
    assert frames.downward([wanted, transform("tb3/odom", "tb3/base_link"), transform("map", "person")]) == [wanted]


def test_a_robot_that_maps_without_odometry_gets_its_pose_in_the_map_and_does_not_send_it_back() -> None:
    frames = Frames()
    pose = [transform("map", "scan_odom"), transform("scan_odom", "base_footprint")]
    assert frames.downward([*pose, transform("base_link", "laser")]) == pose
    assert frames.in_map is None
    assert frames.upward(pose, 0.0, static=False) == []
