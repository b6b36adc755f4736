"""Hostile bytes of robots: messages in CDR and in ROS 1's serialization, tokens of Zenoh, and graphs of them."""

import contextlib
import math
from typing import Any

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage, NotFound
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.graph import Entity, Kind, Qos
from ppaas.wire.ros.rmw_zenoh import ZenohNode, parse_token
from robots.bridges.core.findings import examine
from robots.bridges.core.frames import Frames
from robots.bridges.core.localization import RestartWatch
from robots.bridges.core.robot_graph import TF_MESSAGE, TWIST, RobotGraph, find_namespace
from robots.bridges.core.tables import DOWN, ODOMETRY, ROS_2, SCAN, UP
from tests.support.fuzzing import EXAMPLES
from tests.support.hostile_bytes import mutations

many = settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck))

JAZZY, NOETIC = ros_types("jazzy"), ros_types("noetic")
HEADER = {"stamp": {"sec": 7, "nanosec": 9}, "frame_id": "odom"}
GOOD: tuple[tuple[str, dict[str, Any]], ...] = (
    (ODOMETRY.type, {"header": HEADER, "child_frame_id": "base_link"}),
    (SCAN.type, {"header": HEADER, "ranges": [1.0, math.inf, 2.0], "intensities": [3.0]}),
    (TF_MESSAGE, {"transforms": [{"header": HEADER, "child_frame_id": "laser"}]}),
    ("sensor_msgs/msg/PointCloud2", {"header": HEADER, "fields": [{"name": "x"}], "data": b"12"}),
    ("diagnostic_msgs/msg/DiagnosticArray", {"status": [{"name": "a", "values": [{"key": "b", "value": "c"}]}]}),
    ("nav2_msgs/action/NavigateToPose_SendGoal_Request", {"goal_id": {"uuid": bytes(16)}}),
    ("action_msgs/srv/CancelGoal_Request", {}),
)
CDR = mutations([JAZZY.encode(name, values) for name, values in GOOD])
NODE = ZenohNode(0, "ab12", "/tb3", "talker")
TOKENS = mutations(
    [
        NODE.entity_token(number, Entity(kind, topic, type_name, Qos(), "", "", JAZZY.type_hash(type_name))).encode()
        for number, (kind, topic, type_name) in enumerate(
            [
                (Kind.PUBLISHER, "/tb3/odom", ODOMETRY.type),
                (Kind.PUBLISHER, "/tb3/scan", SCAN.type),
                (Kind.PUBLISHER, "/tb3/tf_static", TF_MESSAGE),
                (Kind.SUBSCRIBER, "/tb3/cmd_vel", TWIST),
                (Kind.SUBSCRIBER, "/tb3/map", "nav_msgs/msg/OccupancyGrid"),
            ]
        )
    ]
)


KINDS = sorted({name for name, _ in GOOD} | {topic.type for topic in (*UP, *DOWN)})


@given(CDR, st.sampled_from(KINDS))
@many
def test_hostile_bytes_are_read_as_a_message_or_refused(data: bytes, kind: str) -> None:
    """Odometry and transforms are used as bridges use them."""
    with contextlib.suppress(MalformedMessage):
        message = JAZZY.decode(kind, data)
        JAZZY.decode_json(kind, data)
        if kind == ODOMETRY.type:
            watch = RestartWatch()
            watch.odometry(message, 0.0)
            watch.odometry(message, 1.0)
            Frames().odometry(message)
        elif kind == TF_MESSAGE:
            Frames().upward(message["transforms"], 0.0, static=False)


@given(mutations([NOETIC.encode(name, values) for name, values in GOOD[:4]]), st.sampled_from(GOOD[:4]))
@many
def test_hostile_bytes_are_read_as_a_message_of_ros_1_or_refused(data: bytes, kind: tuple[str, object]) -> None:
    with contextlib.suppress(MalformedMessage):
        NOETIC.decode_json(kind[0], data)


@given(st.lists(TOKENS, max_size=6), st.sampled_from(["", "/tb3"]))
@many
def test_hostile_bytes_are_read_as_tokens_of_a_graph_or_refused(tokens: list[bytes], namespace: str) -> None:
    entities = []
    for token in tokens:
        with contextlib.suppress(MalformedMessage):
            entity = parse_token(token.decode("utf-8", "replace"))
            entities += [entity] if entity is not None else []
    with contextlib.suppress(NotFound):
        find_namespace(entities, "tb3")
    for finding in examine(RobotGraph(entities, namespace), JAZZY, ROS_2):
        assert finding.text
