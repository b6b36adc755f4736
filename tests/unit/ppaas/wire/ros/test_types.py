"""Messages of ROS as bytes and as JSON.

Hashes and sums are those of ROS itself: the hashes of the packages of Kilted (``share/*/*/*.json``), the sums that
``rosmsg md5`` and ``rossrv md5`` of Noetic print.
"""

import base64
import json
import math
import sys
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, UnknownType
from ppaas.messages import decode
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.wire.ros import ros_types, types

HASHES = {
    "action_msgs/srv/CancelGoal": "573d8b0a534451d7bc2ac8c5ffde8ac14b8593b7001175d0cd6516dcbeb8689a",
    "sensor_msgs/LaserScan": "64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    "rmw_dds_common/msg/Gid": "ab6f21cfbb0a6dbb837161e1110c2051a2850ed9f9c53944d7115d9bcebedf71",
}
SUMS = {
    "geometry_msgs/Twist": "9f195f881246fdfa2798d1d3eebca84a",
    "tf2_msgs/TFMessage": "94810edda583a504dfda3829e70d7eec",
    "move_base_msgs/MoveBaseAction": "70b6aca7c7f7746d8d1609ad94c80bb8",
    "nav_msgs/srv/GetPlan": "421c8ea4d21c6c9db7054b4bbdf1e024",
    "std_srvs/srv/Empty": "d41d8cd98f00b204e9800998ecf8427e",
}

NAMES = st.text("abc/_é", max_size=5)
NUMBERS = st.floats(width=32, allow_nan=False, allow_infinity=False)
STAMPS = st.fixed_dictionaries({"sec": st.integers(-(2**31), 2**31 - 1), "nanosec": st.integers(0, 2**32 - 1)})
HEADERS = st.fixed_dictionaries({"stamp": STAMPS, "frame_id": NAMES})
VECTORS = st.fixed_dictionaries({"x": NUMBERS, "y": NUMBERS, "z": NUMBERS})
QUATERNIONS = st.fixed_dictionaries({"x": NUMBERS, "y": NUMBERS, "z": NUMBERS, "w": NUMBERS})
TRANSFORMS = st.fixed_dictionaries(
    {
        "header": HEADERS,
        "child_frame_id": NAMES,
        "transform": st.fixed_dictionaries({"translation": VECTORS, "rotation": QUATERNIONS}),
    }
)
MESSAGES: st.SearchStrategy[tuple[str, dict[str, Any]]] = st.one_of(
    st.tuples(
        st.just("tf2_msgs/msg/TFMessage"), st.fixed_dictionaries({"transforms": st.lists(TRANSFORMS, max_size=3)})
    ),
    st.tuples(
        st.just("sensor_msgs/msg/LaserScan"),
        st.fixed_dictionaries(
            {"header": HEADERS, "ranges": st.lists(NUMBERS, max_size=5), "intensities": st.lists(NUMBERS, max_size=2)}
        ),
    ),
    st.tuples(
        st.just("sensor_msgs/msg/Image"),
        st.fixed_dictionaries({"header": HEADERS, "height": st.integers(0, 2**32 - 1), "data": st.binary(max_size=9)}),
    ),
    st.tuples(
        st.just("map_msgs/msg/OccupancyGridUpdate"),
        st.fixed_dictionaries({"header": HEADERS, "data": st.lists(st.integers(-128, 127), max_size=9)}),
    ),
)


def same(left: Any, right: Any) -> bool:
    """Return whether a message that was read has the values of the one that was written."""
    if isinstance(left, dict):
        return all(same(value, right[key]) for key, value in left.items())
    if isinstance(left, list) and isinstance(right, np.ndarray):
        return bool(np.array_equal(np.asarray(left, right.dtype), right))
    if isinstance(left, list):
        return len(left) == len(right) and all(map(same, left, right))
    return bool(left == right)


@given(MESSAGES)
def test_a_message_of_ros_2_is_read_as_it_was_written(message: tuple[str, dict[str, Any]]) -> None:
    name, values = message
    assert same(values, ros_types("jazzy").decode(name, ros_types("jazzy").encode(name, values)))


@given(MESSAGES)
def test_json_of_a_message_makes_the_same_bytes_again(message: tuple[str, dict[str, Any]]) -> None:
    name, values = message
    data = ros_types("kilted").encode(name, values)
    assert ros_types("kilted").encode_json(name, ros_types("kilted").decode_json(name, data)) == data


def test_a_message_of_ros_1_has_its_sequence_number_and_its_spelling_of_times() -> None:
    types_ = ros_types("noetic")
    data = types_.encode("std_msgs/Header", {"seq": 7, "stamp": {"secs": 1, "nsecs": 2}, "frame_id": "map"})
    assert data == b"\7\0\0\0\1\0\0\0\2\0\0\0\3\0\0\0map"
    assert types_.decode("std_msgs/Header", data) == {"seq": 7, "stamp": {"secs": 1, "nsecs": 2}, "frame_id": "map"}


def test_cdr_has_the_bytes_that_ros_2_sends() -> None:
    data = ros_types("humble").encode("std_msgs/Header", {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "map"})
    assert data == b"\0\1\0\0" + b"\1\0\0\0\2\0\0\0\4\0\0\0map\0"


@pytest.mark.parametrize(("name", "digits"), HASHES.items())
def test_hashes_are_those_of_ros(name: str, digits: str) -> None:
    assert ros_types("kilted").type_hash(name) == f"RIHS01_{digits}"


def test_services_and_actions_have_hashes_that_differ_by_release() -> None:
    name = "nav2_msgs/action/FollowWaypoints_GetResult"
    assert ros_types("jazzy").type_hash(name) != ros_types("kilted").type_hash(name)
    assert ros_types("humble").type_hash(name) == "TypeHashNotSupported"


@pytest.mark.parametrize(("name", "digits"), SUMS.items())
def test_sums_are_those_of_ros_1(name: str, digits: str) -> None:
    assert ros_types("noetic").md5(name) == digits


def test_a_definition_contains_those_of_the_messages_in_it() -> None:
    text = ros_types("jazzy").definition("nav2_msgs/ParticleCloud")
    assert "Particle[] particles" in text
    assert "MSG: geometry_msgs/Quaternion" in text


def test_json_is_that_of_rosbridge() -> None:
    scan = {"header": {"frame_id": "laser"}, "ranges": [1.1, math.nan, math.inf], "range_max": 8.0}
    data = ros_types("jazzy").encode("sensor_msgs/LaserScan", scan)
    text = json.loads(ros_types("jazzy").decode_json("sensor_msgs/LaserScan", data))
    assert text["ranges"] == [1.1, None, None], "and 1.1 is not 1.10000002384"
    assert decode(LaserScan, json.dumps(text)).header.frame_id == "laser"
    image = ros_types("jazzy").encode("sensor_msgs/Image", {"data": base64.b64encode(b"\1\2").decode()})
    assert json.loads(ros_types("jazzy").decode_json("sensor_msgs/Image", image))["data"] == "AQI="


@pytest.mark.filterwarnings("error")
def test_a_number_that_signals_is_null() -> None:
    types_ = ros_types("jazzy")
    data = types_.encode("sensor_msgs/LaserScan", {"ranges": [7.0]})
    signals = data.replace(np.float32(7.0).tobytes(), b"\1\0\x80\x7f")
    assert json.loads(types_.decode_json("sensor_msgs/LaserScan", signals))["ranges"] == [None]


def test_what_is_left_out_is_zero_and_other_spellings_are_taken() -> None:
    types_ = ros_types("jazzy")
    assert types_.encode("nav_msgs/Odometry", {}) == types_.encode("nav_msgs/Odometry", {"pose": None, "header": {}})
    matrix = [float(number) for number in range(9)]
    camera = types_.decode("sensor_msgs/CameraInfo", types_.encode("sensor_msgs/CameraInfo", {"K": matrix}))
    assert camera["k"].tolist() == matrix
    header = {"seq": 3, "stamp": {"secs": 4, "nsecs": 5}, "frame_id": "map"}
    assert types_.decode("std_msgs/Header", types_.encode("std_msgs/Header", header))["stamp"]["sec"] == 4


@pytest.mark.parametrize(
    ("values", "reason"),
    [
        ({"linear": {"x": "fast"}}, "expected a number at `$.linear.x`, got str"),
        ({"linear": {"speed": 1}}, "geometry_msgs/msg/Vector3 has no field 'speed' at `$.linear`"),
        ({"linear": 3}, "expected an object with the fields of geometry_msgs/msg/Vector3 at `$.linear`"),
        ({"linear": {"x": 10**400}}, "int too large"),
    ],
)
def test_a_wrong_message_is_refused_with_its_place(values: dict[str, Any], reason: str) -> None:
    with pytest.raises(MalformedMessage, match=reason.replace("$", r"\$")):
        ros_types("jazzy").encode("geometry_msgs/Twist", values)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("nav_msgs/OccupancyGrid", {"data": [128]}),
        ("nav_msgs/OccupancyGrid", {"data": [[1]]}),
        ("nav_msgs/OccupancyGrid", {"info": {"width": -1}}),
        ("nav_msgs/OccupancyGrid", {"info": {"width": 1.5}}),
        ("nav_msgs/Odometry", {"pose": {"covariance": [0.0] * 35}}),
        ("nav_msgs/Path", {"poses": {}}),
        ("std_msgs/Header", {"frame_id": 3}),
        ("sensor_msgs/Image", {"data": "A"}),
        ("std_srvs/srv/SetBool_Request", {"data": "yes"}),
    ],
)
def test_values_that_a_type_cannot_have_are_refused(name: str, values: dict[str, Any]) -> None:
    with pytest.raises(MalformedMessage, match=f"not a {name}: "):
        ros_types("jazzy").encode(name, values)


def test_bytes_and_json_that_are_none_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    types_ = ros_types("jazzy")
    for data in (b"", b"\0\1\0\0", b"\0\3\0\0" + bytes(20), types_.encode("nav_msgs/Path", {}) + bytes(4)):
        with pytest.raises(MalformedMessage):
            types_.decode("nav_msgs/Path", data)
    with pytest.raises(MalformedMessage, match="not JSON"):
        types_.encode_json("nav_msgs/Path", b"{")
    monkeypatch.setattr(types, "MAX_MESSAGE", 10)
    with pytest.raises(MessageTooLarge):
        types_.decode("nav_msgs/Path", bytes(11))


def test_unknown_types_and_releases_are_named() -> None:
    with pytest.raises(UnknownType, match="'acme/Thing' is unknown in ROS jazzy"):
        ros_types("jazzy").decode("acme/Thing", b"")
    assert "nav_msgs/Path" in ros_types("jazzy")
    assert "acme/Thing" not in ros_types("jazzy")
    with pytest.raises(InvalidInput, match="known: noetic, humble, jazzy, kilted"):
        types.RosTypes("groovy")


def test_without_rosbags_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(InvalidInput, match=r"pip install '\.\[ros2\]'"):
        types.RosTypes("jazzy")


def test_fields_of_a_message_have_their_lengths_and_bounds() -> None:
    name, _, readers, _ = ros_types("jazzy").fields("rmw_dds_common/msg/NodeEntitiesInfo")
    assert name == types.Field("node_namespace", "string", text_bound=256)
    assert readers == types.Field("reader_gid_seq", "rmw_dds_common/msg/Gid", 0)
    [data] = ros_types("humble").fields("rmw_dds_common/msg/Gid")
    assert (data.type, data.length) == ("uint8", 24)
