"""Codecs of interfaces on robots."""

import json
import struct
import zlib
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, PPaaSError, UnknownType
from ppaas.messages import decode, encode, nav_msgs
from ppaas.messages.base.std_msgs import Header, String, Time
from ppaas.messages.sensor_msgs import CompressedImage, LaserScan
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.messages.vision_msgs import Detection3DArray
from ppaas.wire.rapyuta import message_codec
from ppaas.wire.rapyuta.interface_types import interface_type
from ppaas.wire.rapyuta.message_codec import Converter, Forwarder, codecs_of, graph_class
from tests.support.world.frame_ids import FRAME_IDS


def test_a_client_of_a_service_receives_requests_and_sends_responses() -> None:
    sends, receives = codecs_of(interface_type("ServiceClientConverter"), "nav_msgs/GetPlan")
    request = json.dumps({"start": {"header": {"stamp": {"secs": 1, "nsecs": 0}}}}).encode()
    assert receives.write(request)["start"]["header"]["stamp"] == "1970-01-01T00:00:01.000000"
    response = {"plan": {"header": {"stamp": "1970-01-01T00:00:01"}, "poses": []}}
    assert json.loads(sends.read(response))["plan"]["header"]["stamp"] == {"secs": 1, "nsecs": 0}


def test_a_provider_sends_requests_and_receives_responses() -> None:
    sends, receives = codecs_of(interface_type("ServiceProviderConverter"), "nav_msgs/GetPlan")
    assert json.loads(sends.read({"start": {"header": {"stamp": "1970-01-01T00:00:01"}}}))["start"]["header"]["stamp"]
    assert receives.write(b'{"plan": {"poses": []}}') == {"plan": {"poses": []}}


def test_tf_has_its_name_of_2013() -> None:
    assert graph_class("tf/tfMessage") == "tf2_msgs/TFMessage"
    sends, _ = codecs_of(interface_type("SubscriberForwarder"), "tf/tfMessage")
    assert json.loads(sends.read(sends.write(b'{"transforms": []}'))) == {"transforms": []}


def test_types_of_the_robot_itself_pass_through_a_converter() -> None:
    sends, _ = codecs_of(interface_type("SubscriberConverter"), "my_msgs/Lamp")
    assert json.loads(sends.read({"on": True})) == {"on": True}
    sends, _ = codecs_of(interface_type("ServiceProviderConverter"), "my_msgs/SwitchLamp")
    assert json.loads(sends.read({"on": True})) == {"on": True}


def test_interfaces_of_containers_and_odd_names_are_refused() -> None:
    with pytest.raises(InvalidInput, match="converter or a forwarder"):
        codecs_of(interface_type("PublisherInterface"), "std_msgs/String")
    with pytest.raises(UnknownType):
        codecs_of(interface_type("PublisherConverter"), "String")


SCAN: dict[str, Any] = {"angle_min": -1.0, "angle_max": 1.0, "angle_increment": 1.0, "ranges": [1.0, 2.0, 3.0]}


def test_times_are_text_in_utc() -> None:
    written = Converter(Header).write(encode(Header(7, Time(1377993600, 250_001_999), "map")))
    assert written == {"seq": 7, "stamp": "2013-09-01T00:00:00.250001", "frame_id": "map"}
    read = json.loads(Converter(Header).read({"stamp": "2013-09-01T00:00:00.250001"}))
    assert read == {"stamp": {"secs": 1377993600, "nsecs": 250_001_000}}


@pytest.mark.parametrize(
    ("text", "secs", "nsecs"),
    [
        ("1970-01-01T00:00:01", 1, 0),
        ("1970-01-01T00:00:01.5", 1, 500_000_000),
        ("1970-01-01T01:00:00+01:00", 0, 0),
        ("1970-01-01T00:00:00Z", 0, 0),
    ],
)
def test_times_are_read_in_all_forms_of_iso_8601(text: str, secs: int, nsecs: int) -> None:
    assert json.loads(Converter(Header).read({"stamp": text}))["stamp"] == {"secs": secs, "nsecs": nsecs}


def test_times_of_rosbridge_pass() -> None:
    stamp = {"secs": 5, "nsecs": 6}
    assert json.loads(Converter(Header).read({"stamp": stamp}))["stamp"] == stamp


def test_times_in_lists_and_nested_messages_are_converted() -> None:
    transform = {"header": {"stamp": "1970-01-01T00:00:02", "frame_id": "odom"}, "child_frame_id": "base_link"}
    payload = Converter(TFMessage).read({"transforms": [transform]})
    assert decode(TFMessage, payload).transforms[0].header.stamp == Time(2, 0)
    assert Converter(TFMessage).write(payload)["transforms"][0]["header"]["stamp"] == "1970-01-01T00:00:02.000000"


def test_a_time_that_no_calendar_has_is_the_epoch() -> None:
    written = Converter(Header).write(b'{"stamp": {"secs": 99999999999999, "nsecs": 0}}')
    assert written["stamp"] == "1970-01-01T00:00:00.000000"


def test_ranges_may_be_a_binary_part() -> None:
    ranges = np.array([1.5, np.nan, 2.5], "<f4")
    payload = Converter(LaserScan).read(SCAN | {"header": {"frame_id": "laser"}, "ranges": ranges.tobytes()})
    assert decode(LaserScan, payload).ranges == [1.5, None, 2.5]


def test_a_part_with_half_a_number_is_refused() -> None:
    with pytest.raises(MalformedMessage, match=r"ranges.*5 bytes"):
        Converter(LaserScan).read(SCAN | {"ranges": b"12345"})


def test_bytes_are_binary_parts_in_both_directions() -> None:
    converter = Converter(CompressedImage)
    payload = converter.read({"header": {}, "format": "png", "data": b"\0\xff"})
    assert decode(CompressedImage, payload).data == b"\0\xff"
    assert converter.write(payload)["data"] == b"\0\xff"


def test_a_picture_in_place_of_a_message_is_refused_with_what_to_do() -> None:
    with pytest.raises(MalformedMessage, match="CompressedImage"):
        Converter(CompressedImage).read(b"\x89PNG")


@pytest.mark.parametrize("stamp", ["yesterday", "2013-13-01T00:00:00", "", "0"])
def test_texts_that_are_no_time_are_refused(stamp: str) -> None:
    with pytest.raises(MalformedMessage, match=r"\$\.stamp"):
        Converter(Header).read({"stamp": stamp})


def test_messages_of_unknown_types_pass() -> None:
    assert json.loads(Converter(None).read({"a": 1, "b": b"\1"})) == {"a": 1, "b": "AQ=="}
    assert Converter(None).write(b'{"a": 1}') == {"a": 1}


@given(st.integers(0, 2**31), st.integers(0, 999_999), FRAME_IDS)
def test_headers_come_back_as_they_were(secs: int, micros: int, frame: str) -> None:
    header = Header(1, Time(secs, micros * 1000), frame)
    converter = Converter(Header)
    assert decode(Header, converter.read(converter.write(encode(header)))) == header


KINDS = (Header, String, LaserScan, CompressedImage, TFMessage, nav_msgs.Odometry, Detection3DArray, None)
_JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5) | st.binary(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.sampled_from(["header", "stamp", "secs", "nsecs", "ranges", "data", "transforms", "pose", "x"]), inner
        )
    ),
    max_leaves=10,
)


@given(st.sampled_from(KINDS), _JSON)
def test_any_value_is_read_or_refused(kind: Any, value: Any) -> None:
    converter = Converter(kind)
    try:
        converter.write(converter.read(value))
    except PPaaSError as error:
        assert str(error)


def test_a_message_is_its_serialization_compressed() -> None:
    twist = {"linear": {"x": 0.5, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -1.0}}
    part = Forwarder("geometry_msgs/Twist").write(json.dumps(twist).encode())
    assert struct.unpack("<6d", zlib.decompress(part)) == (0.5, 0.0, 0.0, 0.0, 0.0, -1.0)
    assert json.loads(Forwarder("geometry_msgs/Twist").read(part)) == twist


def test_a_request_of_a_service_is_one_too() -> None:
    codec = Forwarder("nav_msgs/srv/GetPlan_Request")
    assert json.loads(codec.read(codec.write(b'{"tolerance": 0.5}')))["tolerance"] == 0.5


@pytest.mark.parametrize("name", ["my_msgs/Lamp", "nav_msgs/srv/Nothing_Request"])
def test_unknown_types_need_a_converter(name: str) -> None:
    with pytest.raises(InvalidInput, match="use a converter"):
        Forwarder(name)


@pytest.mark.parametrize(
    "message", [{}, "x", None, b"", b"not zlib", zlib.compress(b"short"), zlib.compress(bytes(48))[:-6]]
)
def test_other_parts_are_refused(message: object) -> None:
    with pytest.raises(InvalidInput):
        Forwarder("geometry_msgs/Twist").read(message)


def test_a_bomb_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(message_codec, "MAX_SERIALIZED", 1000)
    with pytest.raises(MessageTooLarge):
        Forwarder("geometry_msgs/Twist").read(zlib.compress(bytes(100_000)))


@given(st.binary(max_size=200), st.booleans())
def test_any_bytes_are_read_or_refused(data: bytes, compressed: bool) -> None:
    codec = Forwarder("sensor_msgs/LaserScan")
    try:
        codec.read(zlib.compress(data) if compressed else data)
    except PPaaSError as error:
        assert str(error)
