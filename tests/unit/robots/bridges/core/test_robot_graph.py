"""One robot in a graph: its namespace and its topics."""

import pytest

from ppaas.errors import NotFound
from ppaas.wire.ros.graph import LATCHED, Entity, Kind, Qos
from robots.bridges.core.robot_graph import TF_MESSAGE, TWIST, TWIST_STAMPED, RobotGraph, find_namespace
from robots.bridges.core.tables import ODOMETRY, SCAN


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
