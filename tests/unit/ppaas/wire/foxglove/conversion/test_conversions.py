"""Messages of a clone as Foxglove draws them."""

import base64
import json
import math
from typing import Any

import pytest
from google.protobuf import descriptor_pb2
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, PPaaSError
from ppaas.messages import decode, encode, geometry_msgs, people_msgs, type_name
from ppaas.messages.base.std_msgs import Header, Time
from ppaas.messages.codec import decode_tolerantly
from ppaas.messages.geometry_msgs import (
    Point,
    Pose,
    PoseArray,
    PoseStamped,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
)
from ppaas.messages.nav_msgs import Path
from ppaas.messages.sensor_msgs import CameraInfo, LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.topics import TOPICS
from ppaas.wire.foxglove.conversion import scenes
from ppaas.wire.foxglove.conversion.base import SharedFrames
from ppaas.wire.foxglove.conversion.conversions import PICTURES, conversion_of
from ppaas.wire.foxglove.conversion.incoming import read_published
from ppaas.wire.ros import ros_types
from ppaas.wire.ros.own_types import types_with
from tests.support.clients.foxglove_viewer import read_protobuf
from tests.support.world.frame_ids import FRAME_IDS

FRAMES = SharedFrames("tb1", "office")
STAMP = Header(stamp=Time(5, 6), frame_id="map")
POSE = geometry_msgs.Pose(geometry_msgs.Point(1.0, 2.0, 3.0), geometry_msgs.Quaternion(x=0.0, y=0.0, z=0.6, w=0.8))
FLOATS = st.floats(allow_nan=False, allow_infinity=False)


def _read(kind: str, data: bytes) -> Any:
    schema = conversion_of(kind).schema
    return read_protobuf({"schema": schema.data, "schemaName": schema.name}, data)


def _converted(message: Any) -> Any:
    kind = type_name(type(message))
    return _read(kind, conversion_of(kind).convert(encode(message), FRAMES))


KINDS = sorted({type_name(topic.type) for topic in TOPICS.values()} - {type_name(CameraInfo)})


@pytest.mark.parametrize("kind", KINDS)
def test_messages_of_each_topic_have_a_schema_and_are_converted(kind: str) -> None:
    cls = next(topic.type for topic in TOPICS.values() if type_name(topic.type) == kind)
    conversion = conversion_of(kind)
    data = conversion.convert(encode(decode_tolerantly(cls, b"{}")), FRAMES)
    assert conversion.schema.encoding in ("cdr", "protobuf")
    if conversion.schema.encoding == "cdr":
        assert types_with(kind).decode(kind, data) is not None
    else:
        assert descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(conversion.schema.data)).file


def test_a_scan() -> None:
    scan = LaserScan(STAMP, -1.0, 1.0, 0.5, 0.1, 4.0, [1.0, None, 0.0, 9.0, 4.0], intensities=[1.0, 2.0])
    found = _converted(scan)
    assert (found.timestamp.seconds, found.timestamp.nanos, found.frame_id) == (5, 6, "office")
    assert (found.start_angle, found.end_angle, list(found.intensities)) == (-1.0, 1.0, [1.0, 2.0])
    assert [None if math.isnan(one) else one for one in found.ranges] == [1.0, None, None, None, 4.0]


def test_transforms_are_one_tree() -> None:
    moved = geometry_msgs.Transform(geometry_msgs.Vector3(1.0, 2.0, 3.0), POSE.orientation)
    message = TFMessage(
        [
            geometry_msgs.TransformStamped(STAMP, "odom", moved),
            geometry_msgs.TransformStamped(Header(frame_id="odom"), "base_link", moved),
        ]
    )
    found = _converted(message).transforms
    assert [(one.parent_frame_id, one.child_frame_id) for one in found] == [
        ("office", "tb1/odom"),
        ("tb1/odom", "tb1/base_link"),
    ]
    assert (found[0].translation.y, found[0].rotation.z) == (2.0, 0.6)


def test_poses_and_paths() -> None:
    assert _converted(PoseStamped(STAMP, POSE)).pose.position.z == 3.0
    for message in (PoseArray(STAMP, [POSE, POSE]), Path(STAMP, [PoseStamped(STAMP, POSE)] * 2)):
        found = _converted(message)
        assert (found.frame_id, len(found.poses), found.poses[1].orientation.w) == ("office", 2, 0.8)


@given(st.lists(FLOATS, min_size=36, max_size=36), st.integers(0, 2**31 - 1), st.integers(0, 10**9 - 1),
       FRAME_IDS.filter(lambda name: not name.startswith("/")))  # fmt: skip
def test_a_pose_with_covariance_is_that_of_the_general_codec(
    covariance: list[float], secs: int, nsecs: int, frame: str
) -> None:
    message = PoseWithCovarianceStamped(
        Header(stamp=Time(secs, nsecs), frame_id=frame), PoseWithCovariance(POSE, covariance)
    )
    kind = type_name(PoseWithCovarianceStamped)
    payload = encode(message)
    data = conversion_of(kind).convert(payload, FRAMES)
    assert data == types_with(kind).encode_json(kind, encode(_with_frame(message, FRAMES.shared(frame))))


def _with_frame(message: PoseWithCovarianceStamped, frame: str) -> PoseWithCovarianceStamped:
    header = Header(stamp=message.header.stamp, frame_id=frame)
    return PoseWithCovarianceStamped(header, message.pose)


@pytest.mark.parametrize(
    ("kind", "payload"),
    [
        ("sensor_msgs/LaserScan", b"{"),
        ("sensor_msgs/LaserScan", b'{"header": {"stamp": {"secs": -1, "nsecs": 0}}}'),
        ("tf2_msgs/TFMessage", b'{"transforms": [7]}'),
        ("nav_msgs/Path", b'{"poses": 7}'),
        ("geometry_msgs/PoseWithCovarianceStamped", b'{"pose": {"covariance": [1]}}'),
        ("nav_msgs/OccupancyGrid", b'{"data": "abc"}'),
        ("nav_msgs/OccupancyGrid", b"[]"),
        ("nav_msgs/OccupancyGrid", b'{"header": '),
    ],
)
def test_messages_of_other_types_are_refused(kind: str, payload: bytes) -> None:
    with pytest.raises(MalformedMessage):
        conversion_of(kind).convert(payload, FRAMES)


def test_a_type_that_nobody_knows_is_json() -> None:
    conversion = conversion_of("my_msgs/Own")
    assert conversion.schema == ("json", "my_msgs/Own", "jsonschema", '{"type":"object"}')
    assert conversion.convert(b'{"a":1}', FRAMES) == b'{"a":1}'
    assert conversion.convert(b'{"header":{"frame_id":"map"}}', FRAMES) == b'{"header":{"frame_id":"office"}}'


def test_people_are_a_scene() -> None:
    message = people_msgs.People(STAMP, [people_msgs.Person("7", geometry_msgs.Point(1.0, 2.0))])
    kind, topic, conversion = PICTURES["people"]
    assert (kind, topic) == (type_name(people_msgs.People), "people/scene")
    schema = conversion.schema
    found = read_protobuf(
        {"schema": schema.data, "schemaName": schema.name}, conversion.convert(encode(message), FRAMES)
    )
    [person] = found.entities
    assert (person.id, person.frame_id, person.lifetime.seconds) == ("tb1/7", "office", 2)
    assert (person.cylinders[0].pose.position.x, person.texts[0].text) == (1.0, "7")


@pytest.mark.parametrize("outline", [(), ((0.5, 0.2), (-0.5, 0.2), (-0.5, -0.2), (0.5, -0.2))])
def test_a_body_has_its_outline_and_name(outline: tuple[tuple[float, float], ...]) -> None:
    data = scenes.body("tb1/base_link", "tb1", outline, radius=0.2, height=0.4)
    schema = scenes.SCENE
    [body] = read_protobuf({"schema": schema.data, "schemaName": schema.name}, data).entities
    corners = [(point.x, point.y) for point in body.lines[0].points]
    if outline:
        assert corners == list(outline)
    else:
        assert all(math.isclose(math.hypot(x, y), 0.2) for x, y in corners)
    assert (body.frame_id, body.frame_locked, body.texts[0].text) == ("tb1/base_link", True, "tb1")


ON_MAP, ALONE = SharedFrames("tb1", "office"), SharedFrames("ann/tb1")
NAMES = st.text("abz_/", min_size=1, max_size=8).map(lambda name: name.strip("/")).filter(bool)


def test_robots_of_a_map_share_its_frame() -> None:
    assert [ON_MAP.shared(frame) for frame in ("map", "/map", "odom", "")] == ["office", "office", "tb1/odom", ""]
    assert [ALONE.shared(frame) for frame in ("map", "odom")] == ["ann/tb1/map", "ann/tb1/odom"]
    assert ON_MAP.shared("tb1/torso_3") == "tb1/torso_3"


@given(NAMES)
def test_a_frame_of_the_tree_is_that_of_the_robot(name: str) -> None:
    for frames in (ON_MAP, ALONE):
        if not name.startswith(f"{frames.robot}/") and name != frames.map:
            assert frames.own(frames.shared(name)) == name


def test_all_frames_of_a_message_are_renamed() -> None:
    message = {
        "header": {"frame_id": "map", "stamp": {"secs": 1}},
        "poses": [{"header": {"frame_id": "odom"}}, {"child_frame_id": "base_link", "ranges": [1.0]}],
        "names": ["map"],
        "frame_id": 7,
    }
    ON_MAP.share_all(message)
    assert message == {
        "header": {"frame_id": "office", "stamp": {"secs": 1}},
        "poses": [{"header": {"frame_id": "tb1/odom"}}, {"child_frame_id": "tb1/base_link", "ranges": [1.0]}],
        "names": ["map"],
        "frame_id": 7,
    }
    ON_MAP.own_all(message)
    assert message["header"] == {"frame_id": "map", "stamp": {"secs": 1}}


KIND = "geometry_msgs/PoseStamped"
NUMBERS = st.floats(-1e6, 1e6)


@given(NUMBERS, NUMBERS, st.integers(0, 2**31 - 1), st.sampled_from(["json", "cdr", "ros1"]))
def test_a_message_is_the_same_in_each_encoding(x: float, y: float, secs: int, encoding: str) -> None:
    shared = PoseStamped(Header(0, Time(secs, 1), "office"), Pose(Point(x, y), Quaternion(z=0.0, w=1.0)))
    text = encode(shared)
    data = (
        text if encoding == "json" else ros_types({"cdr": "jazzy", "ros1": "noetic"}[encoding]).encode_json(KIND, text)
    )
    found = decode(PoseStamped, read_published(encoding, KIND, data, FRAMES))
    assert (found.header.frame_id, found.header.stamp, found.pose) == ("map", Time(secs, 1), shared.pose)


def test_times_of_foxglove_are_read() -> None:
    sent = {"header": {"stamp": {"sec": 1, "nsec": 2}}, "list": [{"sec": 3, "nsec": 4}], "sec": 5}
    found = json.loads(read_published("json", KIND, json.dumps(sent).encode(), FRAMES))
    assert found == {
        "header": {"stamp": {"secs": 1, "nsecs": 2}},
        "list": [{"secs": 3, "nsecs": 4}],
        "sec": 5,
    }


@given(st.sampled_from(["json", "cdr", "ros1"]), st.sampled_from([KIND, "no/Such", "sensor_msgs/LaserScan"]),
       st.binary(max_size=80))  # fmt: skip
def test_any_bytes_are_read_or_refused(encoding: str, kind: str, data: bytes) -> None:
    try:
        read_published(encoding, kind, data, FRAMES)
    except PPaaSError as error:
        assert isinstance(error, InvalidInput)
