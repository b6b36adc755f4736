"""Faults of a robot's graph."""

import pytest

from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import LATCHED, SENSOR, Entity, Kind, Qos
from robots.bridges.core.findings import ERROR, WARN, examine
from robots.bridges.core.robot_graph import TF_MESSAGE, TWIST, TWIST_STAMPED, RobotGraph
from robots.bridges.core.tables import ODOMETRY, ROS_2, SCAN

GRID, PARTICLES = "nav_msgs/msg/OccupancyGrid", "nav2_msgs/msg/ParticleCloud"
TYPES = ros_types("jazzy")


def end(kind: Kind, name: str, type_name: str, qos: Qos | None = None, *, type_hash: str = "") -> Entity:
    return Entity(kind, name, type_name, qos or Qos(), "/node", f"{kind}{name}{type_name}", type_hash)


def publisher(name: str, type_name: str, qos: Qos | None = None, *, type_hash: str = "") -> Entity:
    return end(Kind.PUBLISHER, name, type_name, qos, type_hash=type_hash)


def subscriber(name: str, type_name: str, qos: Qos | None = None, *, type_hash: str = "") -> Entity:
    return end(Kind.SUBSCRIBER, name, type_name, qos, type_hash=type_hash)


ODOM, LASER = publisher("/odom", ODOMETRY.type), publisher("/scan", SCAN.type, SENSOR)
BASE = subscriber("/cmd_vel", TWIST)


def found(*entities: Entity, namespace: str = "", qos_matters: bool = True) -> dict[str, tuple[int, str]]:
    """Return level and text of each finding by its subject."""
    graph = RobotGraph(entities, namespace)
    findings = examine(graph, TYPES, ROS_2, qos_matters=qos_matters)
    assert len({finding.subject for finding in findings}) == len(findings)
    return {finding.subject: (finding.level, finding.text) for finding in findings}


def test_a_healthy_robot_has_none() -> None:
    static = publisher("/tf_static", TF_MESSAGE, LATCHED, type_hash=TYPES.type_hash(TF_MESSAGE))
    rviz = subscriber("/map", GRID, LATCHED, type_hash=TYPES.type_hash(GRID))
    stamped = subscriber("/cmd_vel", TWIST_STAMPED)
    assert not found(ODOM, LASER, BASE, stamped, static, rviz, subscriber("/particle_cloud", PARTICLES, SENSOR))


@pytest.mark.parametrize(
    ("scans", "words"),
    [
        ([], "does not publish 'scan'"),
        ([publisher("/scan", "sensor_msgs/msg/PointCloud2")], "as sensor_msgs/msg/PointCloud2, not as"),
        ([publisher("/front", SCAN.type), publisher("/rear", SCAN.type)], "on /front, /rear; none of them is 'scan'"),
    ],
)
def test_a_topic_that_is_missing_says_what_is_there(scans: list[Entity], words: str) -> None:
    level, text = found(ODOM, BASE, *scans)["scan"]
    assert level == ERROR
    assert words in text


def test_a_namespace_in_which_nothing_is_names_the_others() -> None:
    level, text = found(publisher("/tb2/odom", ODOMETRY.type), LASER, BASE, namespace="/tb1")["odom"]
    assert level == ERROR
    assert "in namespace /tb1, but /tb2/odom (--namespace; known: /, /tb2)" in text


def test_a_base_of_another_type_is_named() -> None:
    assert (
        "as ackermann_msgs/msg/AckermannDrive"
        in found(ODOM, LASER, subscriber("/cmd_vel", "ackermann_msgs/msg/AckermannDrive"))["cmd_vel"][1]
    )


def test_transforms_that_late_subscribers_miss_are_a_warning() -> None:
    level, text = found(ODOM, LASER, BASE, publisher("/tf_static", TF_MESSAGE))["tf_static"]
    assert level == WARN
    assert "not transient local" in text


@pytest.mark.parametrize(
    ("reader", "level", "words"),
    [
        (subscriber("/particle_cloud", PARTICLES), WARN, "it requests 'reliable'"),
        (subscriber("/plan", "nav_msgs/msg/Path", LATCHED), WARN, "it requests 'transient local'"),
        (subscriber("/cmd_vel", TWIST, LATCHED), ERROR, "/node gets nothing of /cmd_vel"),
    ],
)
def test_a_subscriber_that_requests_more_than_is_offered_is_told(reader: Entity, level: int, words: str) -> None:
    base = [] if reader.name == "/cmd_vel" else [BASE]
    told = found(ODOM, LASER, *base, reader)[reader.name]
    assert told[0] == level
    assert words in told[1]
    assert not found(ODOM, LASER, *base, reader, qos_matters=False), "over Zenoh all match"


def test_a_subscriber_of_another_type_is_told() -> None:
    assert (
        "as std_msgs/msg/String, not as"
        in found(ODOM, LASER, BASE, subscriber("/map", "std_msgs/msg/String"))["/map"][1]
    )


@pytest.mark.parametrize("kind", [Kind.PUBLISHER, Kind.SUBSCRIBER])
def test_another_definition_of_a_type_is_an_error(kind: Kind) -> None:
    topic, name = ("/odom", ODOMETRY.type) if kind is Kind.PUBLISHER else ("/map", GRID)
    healthy = [ODOM] if kind is Kind.SUBSCRIBER else []
    level, text = found(*healthy, LASER, BASE, end(kind, topic, name, LATCHED, type_hash="RIHS01_0"))[topic]
    assert level == ERROR
    assert "--distro" in text
