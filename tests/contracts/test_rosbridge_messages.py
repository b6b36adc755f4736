"""Messages of rosbridge clients: rosbridge_suite's conversion as a table, and the definitions of ROS.

The table is that of ``rosbridge_library/internal/message_conversion.py`` of ``RobotWebTools/rosbridge_suite``, which
``test_rosbridge_specification.py`` explains. Members of the kind: fields, headers and stamps that are left out, null or
``"now"``; spellings of ROS 1 and ROS 2; bytes as text and as lists; numbers that are not finite, in a place where they
mean something and where they do not; fields that the type does not have; values of another type.
"""

import hashlib
import json
import math
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.clone.assembly import build_clone
from ppaas.costmap.build_layers import build_layers
from ppaas.errors import MalformedMessage, PPaaSError
from ppaas.maps.grid import GridInfo, GridMap
from ppaas.messages import decode, encode, message_type, message_types
from ppaas.messages.base.message import Message
from ppaas.messages.base.rosapi import GetParamRequest
from ppaas.messages.base.spelling import MAX_TOLERATED
from ppaas.messages.base.std_msgs import Bool, Duration, Header, String, Time
from ppaas.messages.codec import MAX_WITH_BYTES
from ppaas.messages.geometry_msgs import Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion, Twist
from ppaas.messages.nav2_msgs import (
    ClearEntireCostmapRequest,
    ComputePathThroughPosesGoal,
    ComputePathToPoseGoal,
    NavigateThroughPosesGoal,
)
from ppaas.messages.nav_msgs import GetPlanRequest, Odometry
from ppaas.messages.sensor_msgs import CameraInfo, CompressedImage, Image, LaserScan, RegionOfInterest
from ppaas.messages.tf2_msgs import TFMessage
from ppaas.nodes.graph import Graph
from ppaas.wire.typedefs import typedefs

Json = Any


def read(kind: type[Message], value: Json) -> Any:
    return decode(kind, json.dumps(value).encode())


def refusal(kind: type[Message], value: Json) -> str:
    with pytest.raises(MalformedMessage) as refused:
        decode(kind, value if isinstance(value, bytes) else json.dumps(value).encode())
    return str(refused.value)


# -- 3.2.3 Publish: what is left out is filled in with defaults --------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in message_types() if not name.startswith("ppaas_msgs/")])
def test_3_2_3_each_type_may_be_empty(name: str) -> None:
    kind = message_type(name)
    message = read(kind, {})
    assert isinstance(message, kind)
    assert read(kind, json.loads(encode(message))) == message


def test_3_2_3_a_message_that_names_some_of_its_fields_is_whole() -> None:
    odometry = read(Odometry, {"pose": {"pose": {"position": {"x": 1.0}, "orientation": {"w": 1}}}})
    assert odometry.pose.pose == Pose.of(odometry.pose.pose.planar())
    assert odometry.pose.pose.planar() == (1.0, 0.0, 0.0)
    assert (odometry.header, odometry.child_frame_id, odometry.twist.twist) == (Header(), "", Twist())
    assert odometry.pose.covariance == odometry.twist.covariance == [0.0] * 36


@pytest.mark.parametrize("twist", [{}, {"twist": {}}, {"twist": {"twist": {}}}, {"twist": {"twist": {"linear": {}}}}])
def test_3_2_3_odometry_without_a_twist_stands(twist: Json) -> None:
    assert read(Odometry, twist).twist.twist == Twist()


@pytest.mark.parametrize("orientation", [{}, {"orientation": {}}, {"orientation": {"x": 0, "y": 0, "z": 0, "w": 0}}])
def test_3_2_3_an_orientation_that_is_left_out_is_zero_as_in_ros_1(orientation: Json) -> None:
    """It is refused where it is used: see the test of a whole clone below."""
    assert read(Pose, orientation).orientation == Quaternion(z=0.0, w=0.0)


@pytest.mark.parametrize(
    "header",
    [{}, {"header": None}, {"header": {}}, {"header": {"stamp": None}}, {"header": {"seq": None, "frame_id": None}}],
)
@pytest.mark.parametrize("kind", [LaserScan, Odometry, PoseStamped, Image, CameraInfo, PoseWithCovarianceStamped])
def test_3_2_3_a_header_may_be_left_out_or_null(kind: type[Message], header: Json) -> None:
    assert read(kind, header).header == Header()


@pytest.mark.parametrize("stamp", ["now", None, {}, {"secs": 0, "nsecs": 0}, {"sec": 0}])
def test_3_2_3_a_stamp_that_is_left_out_null_or_now_means_now(stamp: Json) -> None:
    header = read(PoseStamped, {"header": {"seq": 1, "stamp": stamp, "frame_id": "map"}}).header
    assert header == Header(1, Time(), "map")


@pytest.mark.parametrize(
    "stamp", [{"secs": 1, "nsecs": 2}, {"sec": 1, "nanosec": 2}, {"secs": 1, "nanosec": 2}, {"sec": 1, "nsecs": 2}]
)
def test_3_2_3_times_have_the_names_of_ros_1_or_ros_2(stamp: Json) -> None:
    assert read(Header, {"stamp": stamp}).stamp == Time(1, 2)
    assert read(Duration, stamp) == Duration(1, 2)


@pytest.mark.parametrize("stamp", [5, 5.5, "yesterday", "", [1, 2], True, {"seconds": 1}, {"secs": "1"}])
def test_3_2_3_any_other_stamp_is_refused(stamp: Json) -> None:
    """rosbridge_suite takes most of these for zero, and says nothing."""
    assert "stamp" in refusal(PoseStamped, {"header": {"stamp": stamp}})


@pytest.mark.parametrize(
    ("kind", "value", "field"),
    [
        (Odometry, {"posse": {}}, "'posse' at `$`"), (PoseStamped, {"pose": {"positon": {}}}, "'positon' at `$.pose`"),
        (Twist, {"linear": {"X": 1}}, "'X' at `$.linear`"), (Header, {"frame": "map"}, "'frame' at `$`"),
        (TFMessage, {"transforms": [{}, {"child": "x"}]}, "'child' at `$.transforms[1]`"),
        (Time, {"s": 1}, "'s' at `$`"), (GetPlanRequest, {"tolerence": 1}, "'tolerence' at `$`"),
    ],
)  # fmt: skip
def test_3_2_3_a_field_that_the_type_does_not_have_is_refused_with_those_it_has(
    kind: type[Message], value: Json, field: str
) -> None:
    text = refusal(kind, value)
    assert f"has no field {field}" in text and "its fields are: " in text


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (Odometry, {"child_frame_id": 7}), (Odometry, {"pose": []}), (PoseStamped, {"pose": {"position": {"x": "1"}}}),
        (Twist, {"linear": 3}), (Bool, {"data": 1}), (Bool, {"data": "true"}), (String, {"data": 5}),
        (Header, {"seq": 1.5}), (LaserScan, {"ranges": 1}), (LaserScan, {"ranges": ["1"]}), (Image, {"height": "4"}),
        (TFMessage, {"transforms": {}}), (TFMessage, {"transforms": [7]}), (PoseStamped, []), (PoseStamped, None),
        (PoseStamped, "now"),
    ],
)  # fmt: skip
def test_3_2_3_a_value_of_another_type_is_refused_with_its_place(kind: type[Message], value: Json) -> None:
    assert "`$" in refusal(kind, value)


def test_3_2_3_a_whole_number_is_a_decimal_one() -> None:
    assert read(Twist, {"linear": {"x": 1}}).linear.x == 1.0


# -- numbers that are not finite ---------------------------------------------------------------------------------------

NOT_FINITE = [b"NaN", b"Infinity", b"-Infinity", b"1e400", b"-1e400", b"null"]


@pytest.mark.parametrize("word", NOT_FINITE)
def test_3_1_no_reading_of_a_scan_may_be_written_in_any_way(word: bytes) -> None:
    scan = decode(LaserScan, b'{"ranges": [1.5, %b, 2], "intensities": [%b]}' % (word, word))
    assert (scan.ranges, scan.intensities) == ([1.5, None, 2.0], [None])


@pytest.mark.parametrize("word", NOT_FINITE)
def test_3_1_an_unknown_covariance_is_zero(word: bytes) -> None:
    odometry = decode(Odometry, b'{"pose": {"covariance": [%b, 2.5, %b]}}' % (word, word))
    assert odometry.pose.covariance == [0.0, 2.5, 0.0]


@pytest.mark.parametrize("word", NOT_FINITE)
@pytest.mark.parametrize(
    ("kind", "form"),
    [
        (PoseStamped, b'{"pose": {"position": {"x": %b}}}'), (Twist, b'{"angular": {"z": %b}}'),
        (LaserScan, b'{"angle_min": %b}'), (CameraInfo, b'{"K": [%b]}'), (GetPlanRequest, b'{"tolerance": %b}'),
        (TFMessage, b'{"transforms": [{"transform": {"rotation": {"w": %b}}}]}'),
    ],
)  # fmt: skip
def test_3_1_where_a_number_is_needed_it_must_be_finite(kind: type[Message], form: bytes, word: bytes) -> None:
    text = refusal(kind, form % word)
    assert "NaN and infinity are none" in text and "`$" in text


@given(st.recursive(st.floats() | st.text() | st.none(), lambda inner: st.dictionaries(st.text(), inner), max_leaves=5))
def test_3_1_any_json_of_python_is_a_message_or_malformed(value: Json) -> None:
    for kind in (LaserScan, PoseStamped, Image):
        try:
            message = decode(kind, json.dumps(value).encode())
        except MalformedMessage:
            continue
        assert message == read(kind, {})


# -- 4.6 Data type encoding --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("data", ["AAH/", "AAH/\n", "AA\r\nH/", [0, 1, 255]])
@pytest.mark.parametrize("kind", [Image, CompressedImage])
def test_4_6_bytes_are_base64_or_a_list_of_numbers(kind: type[Message], data: Json) -> None:
    assert read(kind, {"data": data}).data == b"\x00\x01\xff"


def test_4_6_bytes_are_sent_as_base64() -> None:
    assert json.loads(encode(read(CompressedImage, {"data": [0, 1, 255]})))["data"] == "AAH/"


@pytest.mark.parametrize("data", ["AAH", "é", [256], [-1], [1.5], ["1"], [None], 7, {}, None, True])
def test_4_6_what_is_neither_is_refused(data: Json) -> None:
    assert "`$.data`" in refusal(Image, {"data": data})


# -- spellings of ROS 2 ------------------------------------------------------------------------------------------------


def test_a_camera_info_has_the_names_of_ros_1_or_ros_2() -> None:
    matrices = {"D": [0.1], "K": [1.0] * 9, "R": [2.0] * 9, "P": [3.0] * 12}
    lower = {name.lower(): matrix for name, matrix in matrices.items()}
    header = {"stamp": {"sec": 1, "nanosec": 2}}
    assert read(CameraInfo, lower | {"header": header}) == read(
        CameraInfo, matrices | {"header": {"stamp": {"secs": 1, "nsecs": 2}}}
    )
    assert read(CameraInfo, {"roi": {"width": 4, "do_rectify": True}}).roi == RegionOfInterest(width=4, do_rectify=True)


def test_the_default_of_get_param_has_the_name_of_ros_1_or_ros_2() -> None:
    assert read(GetParamRequest, {"name": "a", "default_value": "1"}) == read(
        GetParamRequest, {"name": "a", "default": "1"}
    )


# -- bounds ------------------------------------------------------------------------------------------------------------


GOAL = {"header": {"frame_id": "odom"}, "pose": {"position": {"x": 1.0}}}
BARE_GOAL = {"pose": {"position": {"x": 1.0}}}


@pytest.mark.parametrize(
    ("kind", "field"), [(NavigateThroughPosesGoal, "poses"), (ComputePathThroughPosesGoal, "goals")]
)
def test_poses_of_nav2_are_a_list_or_goals_as_since_kilted(kind: type[Message], field: str) -> None:
    goals = {"header": {"stamp": {"sec": 3, "nanosec": 0}, "frame_id": "map"}, "goals": [GOAL, BARE_GOAL]}
    first, second = getattr(read(kind, {field: goals}), field)
    assert first == getattr(read(kind, {field: [GOAL]}), field)[0], "a pose with a frame keeps it"
    assert (second.header.frame_id, second.header.stamp, second.pose.position.x) == ("map", Time(3), 1.0)
    assert getattr(read(kind, {field: {}}), field) == []
    assert "has no field 'poses_'" in refusal(kind, {field: {"poses_": []}})
    assert f"`$.{field}`" in refusal(kind, {field: 3})


def test_goals_of_lyrical_have_viapoints_and_requests_to_clear_have_plugins() -> None:
    assert [pose.pose.position.x for pose in read(ComputePathToPoseGoal, {"viapoints": [GOAL]}).viapoints] == [1.0]
    assert read(ComputePathToPoseGoal, {"goal": GOAL}).viapoints == []
    assert read(ClearEntireCostmapRequest, {"plugins": ["obstacle_layer"]}).plugins == ["obstacle_layer"]
    assert read(ClearEntireCostmapRequest, {"request": {}}).plugins == []


def test_the_largest_scan_of_infinities_is_read_and_a_larger_one_is_refused() -> None:
    largest = b'{"ranges": [' + b"Infinity," * 100_000 + b"1]}"
    assert len(largest) < MAX_TOLERATED
    assert decode(LaserScan, largest).ranges.count(None) == 100_000
    assert "larger than 1024 KiB" in refusal(LaserScan, b'{"ranges": [' + b"Infinity," * 200_000 + b"1]}")


def test_an_image_as_a_list_is_read_up_to_the_size_of_a_frame() -> None:
    listed = b'{"data": [' + b"255," * 614_400 + b"0]}"
    assert MAX_TOLERATED < len(listed) < MAX_WITH_BYTES
    assert len(decode(Image, listed).data) == 614_401


@pytest.mark.parametrize("deep", [b"[" * 100_000, b'{"a":' * 100_000, b'{"pose":' * 100_000])
def test_nesting_without_end_is_malformed(deep: bytes) -> None:
    refusal(PoseStamped, deep)


# -- definitions -------------------------------------------------------------------------------------------------------

MD5 = {
    "actionlib_msgs/GoalID": "302881f31927c1df708a2dbab0e80ee8",
    "actionlib_msgs/GoalStatus": "d388f9b87b3c471f784434d671988d4a",
    "actionlib_msgs/GoalStatusArray": "8b2b82f13216d0a8ea88bd3af735e619",
    "geometry_msgs/Point": "4a842b65f413084dc2b10fb484ea7f17",
    "geometry_msgs/Point32": "cc153912f1453b708d221682bc23d9ac",
    "geometry_msgs/Polygon": "cd60a26494a087f577976f0329fa120e",
    "geometry_msgs/PolygonStamped": "c6be8f7dc3bee7fe9e8d296070f53340",
    "geometry_msgs/Pose": "e45d45a5a1ce597b249e23fb30fc871f",
    "geometry_msgs/PoseArray": "916c28c5764443f268b296bb671b9d97",
    "geometry_msgs/PoseStamped": "d3812c3cbc69362b77dc0b19b345f8f5",
    "geometry_msgs/PoseWithCovariance": "c23e848cf1b7533a8d7c259073a97e6f",
    "geometry_msgs/PoseWithCovarianceStamped": "953b798c0f514ff060a53a3498ce6246",
    "geometry_msgs/Quaternion": "a779879fadf0160734f906b8c19c7004",
    "geometry_msgs/Transform": "ac9eff44abf714214112b05d54a3cf9b",
    "geometry_msgs/TransformStamped": "b5764a33bfeb3588febc2682852579b0",
    "geometry_msgs/Twist": "9f195f881246fdfa2798d1d3eebca84a",
    "geometry_msgs/TwistStamped": "98d34b0043a2093cf9d9345ab6eef12e",
    "geometry_msgs/TwistWithCovariance": "1fe8a28e6890a4cc3ae4c3ca5c7d82e6",
    "geometry_msgs/Vector3": "4a842b65f413084dc2b10fb484ea7f17",
    "move_base_msgs/MoveBaseActionFeedback": "7d1870ff6e0decea702b943b5af0b42e",
    "move_base_msgs/MoveBaseActionGoal": "660d6895a1b9a16dce51fbdd9a64a56b",
    "move_base_msgs/MoveBaseActionResult": "1eb06eeff08fa7ea874431638cb52332",
    "nav_msgs/MapMetaData": "10cfc8a2818024d3248802c00c95f11b",
    "nav_msgs/OccupancyGrid": "3381f2d731d4076ec5c71b0759edbe4e",
    "nav_msgs/Odometry": "cd5e73d190d741a2f92e81eda573aca7",
    "nav_msgs/Path": "6227e2b7e9cce15051f669a5e197bbf7",
    "sensor_msgs/CameraInfo": "c9a58c1b0b154e0e6da7578cb991d214",
    "sensor_msgs/CompressedImage": "8f7a12909da2c9d3332d540a0977563f",
    "sensor_msgs/Image": "060021388200f6f0f447d0fcd9c64743",
    "sensor_msgs/LaserScan": "90c7ef2dc6895d81024acba2ac42f369",
    "std_msgs/Bool": "8b94c1b53db61fb6aed406028ad6332a",
    "std_msgs/Float64": "fdb28210bfa9d7c91146260178d9a584",
    "std_msgs/Header": "2176decaecbce78abc3b96ef049fabed",
    "std_msgs/String": "992ce8a1687cec8c8bd883ec73ca41d1",
    "tf2_msgs/TFMessage": "94810edda583a504dfda3829e70d7eec",
}
"""MD5 sums of the definitions in ROS 1, by which nodes and bags recognize a type (``rosmsg md5``)."""


def md5_of(name: str) -> str:
    """Return the MD5 sum of a type, from the definition that rosapi gives: constants, then fields."""
    definition = typedefs(message_type(name))[0]
    constants = zip(definition.constnames, definition.constvalues, strict=True)
    lines = [f"uint8 {constant}={value}" for constant, value in constants]
    fields = zip(definition.fieldnames, definition.fieldtypes, definition.fieldarraylen, strict=True)
    for field, kind, length in fields:
        array = {-1: "", 0: "[]"}.get(length, f"[{length}]")
        lines.append(f"{md5_of(kind)} {field}" if "/" in kind else f"{kind}{array} {field}")
    return hashlib.md5("\n".join(lines).encode(), usedforsecurity=False).hexdigest()


@pytest.mark.parametrize("name", MD5)
def test_a_definition_has_the_md5_sum_of_ros(name: str) -> None:
    assert md5_of(name) == MD5[name]


# -- a whole clone -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def graph() -> Graph:
    clone = Graph()
    layers = build_layers(GridMap(np.zeros((40, 40), np.int8), GridInfo(0.05, 40, 40)), robot_radius=0.18)
    parameters = {"depthimage_to_laserscan": {}}
    build_clone(clone, layers, model="turtlebot2", initial_pose=(1.0, 1.0, 0.0), parameters=parameters)
    return clone


PARTS: list[Json] = [
    {}, {"header": {"frame_id": "map"}}, {"pose": {"orientation": {"w": 1}}}, {"ranges": [1, None, 2]},
    {"ranges": [None] * 3, "angle_increment": 0.1, "range_max": 5.0}, {"goal": {"target_pose": {"pose": {}}}},
    {"transforms": [{}]}, {"transforms": [{"child_frame_id": "x", "transform": {"rotation": {"w": 1}}}]},
    {"people": [{}]}, {"goal": {"poses": [{}]}}, {"goal": {"source_frames": ["a"]}}, {"data": [1, 2]}, {"K": [1.0] * 9},
]  # fmt: skip


@pytest.mark.parametrize("part", PARTS, ids=json.dumps)
def test_a_clone_takes_or_refuses_what_is_filled_up_with_defaults(graph: Graph, part: Json) -> None:
    for name, topic in graph.topics.items():
        try:
            graph.inject(name, decode(topic.type, json.dumps(part).encode()))
        except PPaaSError as error:
            assert str(error)


@pytest.mark.parametrize("topic", ["odom", "initialpose", "move_base_simple/goal", "move_base/goal"])
def test_a_clone_refuses_an_orientation_of_zeros_where_it_is_used(graph: Graph, topic: str) -> None:
    with pytest.raises(PPaaSError, match=r"orientation of .* is all zero; without rotation it has w = 1"):
        graph.inject(topic, decode(graph.topics[topic].type, b"{}"))


def test_a_clone_is_localized_by_odometry_and_scans_without_headers(graph: Graph) -> None:
    poses: list[Any] = []
    graph.tap("amcl_pose", lambda _, message: poses.append(message))
    graph.inject("odom", decode(Odometry, b'{"pose": {"pose": {"orientation": {"w": 1}}}}'))
    scan = {"angle_min": -1.0, "angle_max": 1.0, "angle_increment": 0.5, "range_min": 0.1, "range_max": 8.0}
    text = json.dumps(scan | {"ranges": [math.inf] * 5})
    graph.inject("scan", decode(LaserScan, text.encode()))
    assert len(poses) == 1
    assert msgspec.to_builtins(poses[0].header)["frame_id"] == "map"
