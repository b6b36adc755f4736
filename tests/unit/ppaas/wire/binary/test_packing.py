"""Packing of messages for clients, and binary frames of theirs."""

import base64
import io
import json
import math
import struct
import sys
from typing import Any

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from rosbags.typesys import Stores, get_typestore

from ppaas.errors import MalformedMessage, UnknownType
from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.binary.cbor import RosType
from ppaas.wire.binary.packing import Packer, operation_of, png_frame
from ppaas.wire.ros.serialization import serialize
from ppaas.wire.ros.types import ros_types
from ppaas.wire.rosbridge import RosbridgeSession

ROS_1, ROS_2 = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
SCAN = {"header": {"frame_id": "laser", "stamp": {"secs": 7, "nsecs": 9}}, "ranges": [1.5, None]}

TWIST = {"linear": {"x": 0.5, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -0.25}}
COMPACT_TWIST = struct.pack("<BBHI3f", 3, 0, 3, 0, 0.5, 0.0, -0.25)


def frames(packer: Packer, *subscriptions: dict[str, Any], topic: str = "cmd_vel", message: Any = TWIST) -> list[bytes]:
    """Return the frames of a message for a client with these subscriptions to its topic."""
    session = RosbridgeSession(packer=packer)
    for number, fields in enumerate(subscriptions):
        session.receive(json.dumps({"op": "subscribe", "topic": topic, "id": str(number)} | fields))
    return list(session.publish(topic, json.dumps(message).encode(), 0.0))


def kind_of(frame: bytes) -> str:
    if not isinstance(frame, BinaryFrame):
        return "png" if json.loads(frame)["op"] == "png" else "json"
    return "compact" if frame[0] == 3 else "cbor"


@pytest.mark.parametrize("compression", [None, "none", "zip", ""])
def test_json_is_sent_without_a_known_compression(compression: str | None) -> None:
    [frame] = frames(Packer(), {"compression": compression})
    assert json.loads(frame) == {"op": "publish", "topic": "cmd_vel", "msg": TWIST}


@pytest.mark.parametrize("compression", ["png", "cbor"])
def test_a_subscription_is_packed_as_it_asks(compression: str) -> None:
    assert [kind_of(frame) for frame in frames(Packer(), {"compression": compression})] == [compression]


def test_the_strongest_compression_of_several_subscriptions_counts() -> None:
    asked = [{"compression": "png"}, {"compression": "cbor"}, {}]
    assert [kind_of(frame) for frame in frames(Packer(), *asked)] == ["cbor"]
    assert [kind_of(frame) for frame in frames(Packer(), asked[0], asked[2])] == ["png"]


def test_each_spelling_of_a_topic_has_its_own_compression() -> None:
    found = frames(Packer(), {"topic": "/cmd_vel", "compression": "cbor"}, {"topic": "cmd_vel"})
    assert [kind_of(frame) for frame in found] == ["cbor", "json"]


def test_a_client_that_cannot_read_png_gets_json() -> None:
    assert [kind_of(frame) for frame in frames(Packer(png=False), {"compression": "png"})] == ["json"]
    assert [kind_of(frame) for frame in frames(Packer(png=False), {"compression": "cbor"})] == ["cbor"]


def test_velocities_are_compact_for_a_client_that_asked_for_it() -> None:
    assert frames(Packer(compact=True), {}) == [COMPACT_TWIST]
    assert frames(Packer(compact=True), {"compression": "none"}) == [COMPACT_TWIST]
    assert kind_of(frames(Packer(compact=True), {"compression": "cbor"})[0]) == "cbor"
    assert kind_of(frames(Packer(compact=True), {}, topic="plan")[0]) == "json"


@pytest.mark.parametrize("message", [{"linear": 5}, [1], None])
def test_a_velocity_of_a_client_that_is_none_is_sent_as_json(message: Any) -> None:
    [frame] = frames(Packer(compact=True), {}, message=message)
    assert json.loads(frame)["msg"] == message


def test_cbor_has_typed_arrays_by_the_type_of_the_topic() -> None:
    packer = Packer()
    packer.type_of = {"scan": "sensor_msgs/LaserScan"}.get
    [frame] = frames(packer, {"compression": "cbor"}, topic="scan", message={"ranges": [1.0]})
    assert cbor2.loads(frame)["msg"]["ranges"].tag == 85


def raw(packer: Packer, *subscriptions: dict[str, Any], topic: str = "scan", message: Any = SCAN) -> list[Any]:
    return [cbor2.loads(frame) for frame in frames(packer, *subscriptions, topic=topic, message=message)]


@pytest.mark.parametrize(("kind", "store"), [("sensor_msgs/LaserScan", ROS_1), ("sensor_msgs/msg/LaserScan", ROS_2)])
def test_raw_messages_are_of_the_version_of_ros_that_spells_the_type_so(kind: str, store: Any) -> None:
    packer = Packer(serialize=serialize, now=lambda: 12.5)
    [frame] = raw(packer, {"compression": "cbor-raw", "type": kind})
    assert (frame["op"], frame["topic"], frame["msg"]["secs"], frame["msg"]["nsecs"]) == (
        "publish",
        "scan",
        12,
        5 * 10**8,
    )
    scan = read(store, frame["msg"]["bytes"])
    assert (scan.header.frame_id, scan.header.stamp.sec, scan.header.stamp.nanosec) == ("laser", 7, 9)
    assert scan.ranges[0] == 1.5 and math.isnan(scan.ranges[1])


def read(store: Any, data: bytes) -> Any:
    deserialize = store.deserialize_ros1 if store is ROS_1 else store.deserialize_cdr
    return deserialize(data, "sensor_msgs/msg/LaserScan")


def test_raw_messages_without_a_type_are_those_of_ros_1() -> None:
    packer = Packer(serialize=serialize)
    packer.type_of = {"scan": "sensor_msgs/LaserScan"}.get
    [frame] = raw(packer, {"compression": "cbor-raw"})
    assert read(ROS_1, frame["msg"]["bytes"]).header.frame_id == "laser"


def test_raw_is_the_strongest_compression() -> None:
    asked = [{"compression": "cbor-raw", "type": "sensor_msgs/LaserScan"}, {"compression": "cbor"}]
    [frame] = raw(Packer(serialize=serialize), *asked)
    assert set(frame["msg"]) == {"secs", "nsecs", "bytes"}


@pytest.mark.parametrize(("kind", "reason"), [("my_msgs/Own", "my_msgs/Own"), ("a/b/c", "a/b/c")])
def test_a_type_that_ros_has_not_is_sent_as_json_and_told(kind: str, reason: str) -> None:
    objection = Packer(serialize=serialize).objection("scan", "cbor-raw", RosType(kind))
    assert isinstance(objection, UnknownType)
    assert reason in str(objection) and "JSON is sent" in str(objection)
    [frame] = frames(Packer(serialize=serialize), {"compression": "cbor-raw", "type": "my_msgs/Own"})
    assert kind_of(frame) == "json"


def test_a_topic_without_a_type_gets_no_objection_and_json_until_it_has_one() -> None:
    packer = Packer(serialize=serialize)
    assert packer.objection("scan", "cbor-raw") is None
    assert kind_of(frames(packer, {"compression": "cbor-raw"}, topic="scan", message=SCAN)[0]) == "json"


@pytest.mark.parametrize("message", [{"ranges": 5}, [1], {"header": {"stamp": -1}}, {"no": 1}, {"ranges": [[1]]}])
def test_a_message_that_is_not_of_its_type_is_sent_as_json(message: Any) -> None:
    asked = {"compression": "cbor-raw", "type": "sensor_msgs/LaserScan"}
    [frame] = frames(Packer(serialize=serialize), asked, topic="scan", message=message)
    assert json.loads(frame)["msg"] == message


def test_without_the_extra_json_is_sent_and_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags", None)
    serialize.cache_clear()
    ros_types.cache_clear()
    packer = Packer(serialize=serialize)
    assert "pip install '.[ros2]'" in str(packer.objection("scan", "cbor-raw"))
    assert kind_of(frames(packer, {"compression": "cbor-raw"})[0]) == "json"


def test_all_subscribers_share_what_is_encoded() -> None:
    clients = [RosbridgeSession(packer=Packer(serialize=serialize)) for _ in range(5)]
    asked = {"op": "subscribe", "topic": "/scan", "type": "sensor_msgs/msg/LaserScan", "compression": "cbor-raw"}
    for client in clients:
        client.receive(json.dumps(asked))
    serialize.cache_clear()
    message = json.dumps(SCAN).encode()
    frames_of_all = [frame for client in clients for frame in client.publish("scan", message, 0.0)]
    assert (len(frames_of_all), serialize.cache_info().misses) == (5, 1)


def test_a_delayed_message_is_packed_too() -> None:
    session = RosbridgeSession()
    session.receive('{"op": "subscribe", "topic": "a", "compression": "cbor", "throttle_rate": 100}')
    first = list(session.publish("a", b"1", 0.0))
    assert list(session.publish("a", b"2", 0.01)) == []
    [(_, second)] = session.due(1.0)
    assert [cbor2.loads(frame)["msg"] for frame in (*first, second)] == [1, 2]


def test_a_binary_frame_of_json_is_its_text() -> None:
    assert operation_of(b'\xef\xbb\xbf {"op": "x"}') == b'\xef\xbb\xbf {"op": "x"}'


def test_a_binary_frame_of_cbor_is_the_json_for_which_it_stands() -> None:
    assert json.loads(operation_of(cbor2.dumps({"op": "x", "a": [1]}))) == {"op": "x", "a": [1]}


def test_a_compact_frame_is_the_publication_for_which_it_stands() -> None:
    assert json.loads(operation_of(COMPACT_TWIST)) == {"op": "publish", "topic": "cmd_vel", "msg": TWIST}


@pytest.mark.parametrize("first", [0x01, 0x02, 0xA1, 0x7B])
def test_bson_is_recognized_whatever_its_length(first: int) -> None:
    size = 0x100 + first
    document = size.to_bytes(4, "little") + b"\x02op\0" + bytes(size - 8)
    with pytest.raises(MalformedMessage, match="BSON is not supported"):
        operation_of(document)


def test_other_bytes_are_refused_with_what_is_taken() -> None:
    with pytest.raises(MalformedMessage, match="JSON in UTF-8, CBOR of an operation, or a compact frame"):
        operation_of(b"\xff\xfe{")


def text_in(frame: bytes) -> str:
    """Return the text in a frame of ``png`` as web pages read it: each byte of a pixel is a character."""
    operation = json.loads(frame)
    assert operation["op"] == "png"
    image = Image.open(io.BytesIO(base64.b64decode(operation["data"])))
    assert image.mode == "RGB"
    return image.tobytes().decode("latin-1")


@given(st.dictionaries(st.text(), st.text()))
def test_a_frame_comes_back_from_the_pixels(message: dict[str, str]) -> None:
    frame = json.dumps(message, ensure_ascii=False).encode()
    assert json.loads(text_in(png_frame(frame))) == message


def test_an_image_is_nearly_square_and_padded_with_line_feeds() -> None:
    frame = json.dumps({"a": "x" * 1000}).encode()
    image = Image.open(io.BytesIO(base64.b64decode(json.loads(png_frame(frame))["data"])))
    assert (image.width, image.height) == (18, 19)
    assert text_in(png_frame(frame)) == frame.decode().ljust(18 * 19 * 3, "\n")


def test_a_map_becomes_smaller() -> None:
    frame = json.dumps({"data": [0, 100, -1] * 5000}).encode()
    assert len(png_frame(frame)) < len(frame) / 20
