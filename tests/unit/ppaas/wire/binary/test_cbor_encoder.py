"""Messages in CBOR as rosbridge_suite sends them."""

import base64
import json
import math
from typing import Any

import cbor2
import numpy as np
import pytest

from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.binary.cbor import cbor_frame

POSE = {"position": {"x": 1.0}, "orientation": {"w": 1.0}}


def sent(message: Any, kind: str | None) -> Any:
    frame = cbor_frame("/t", json.dumps(message).encode(), kind)
    assert isinstance(frame, BinaryFrame)
    decoded = cbor2.loads(frame)
    assert (decoded["op"], decoded["topic"]) == ("publish", "/t")
    return decoded["msg"]


def numbers(tagged: Any, tag: int, kind: str) -> list[float]:
    assert (type(tagged), tagged.tag) == (cbor2.CBORTag, tag)
    found: list[float] = np.frombuffer(tagged.value, kind).tolist()
    return found


def test_ranges_are_a_typed_array_of_float32_in_which_null_is_nan() -> None:
    message = sent({"ranges": [1.5, None, 2], "header": {"frame_id": "a"}}, "sensor_msgs/LaserScan")
    first, second, third = numbers(message["ranges"], 85, "<f4")
    assert (first, third, message["header"]) == (1.5, 2.0, {"frame_id": "a"})
    assert math.isnan(second)


def test_cells_are_a_typed_array_of_int8() -> None:
    assert numbers(sent({"data": [0, -1, 100]}, "nav_msgs/OccupancyGrid")["data"], 72, "i1") == [0, -1, 100]


def test_a_covariance_within_other_messages_is_a_typed_array_of_float64() -> None:
    odometry = sent({"pose": {"pose": POSE, "covariance": [0.5] * 36}}, "nav_msgs/Odometry")
    assert numbers(odometry["pose"]["covariance"], 86, "<f8") == [0.5] * 36
    assert odometry["pose"]["pose"] == POSE


def test_bytes_are_a_byte_string() -> None:
    image = {"data": base64.b64encode(b"\0\xff").decode(), "height": 1}
    assert sent(image, "sensor_msgs/Image") == {"data": b"\0\xff", "height": 1}
    assert sent({"data": [0, 255]}, "sensor_msgs/Image") == {"data": b"\0\xff"}


def test_lists_of_messages_are_lists() -> None:
    path = {"poses": [{"pose": POSE}, {"pose": POSE}]}
    assert sent(path, "nav_msgs/Path") == path
    image = {"fields": [{"name": "x", "offset": 0}], "data": "AA=="}
    assert sent(image, "sensor_msgs/PointCloud2") == image | {"data": b"\0"}


def test_matrices_of_a_camera_have_both_spellings() -> None:
    camera = sent({"K": [1.0] * 9, "k": [2.0] * 9}, "sensor_msgs/CameraInfo")
    assert numbers(camera["K"], 86, "<f8") == [1.0] * 9
    assert numbers(camera["k"], 86, "<f8") == [2.0] * 9


@pytest.mark.parametrize("kind", [None, "my_msgs/Unknown"])
def test_a_message_of_an_unknown_type_has_plain_lists(kind: str | None) -> None:
    assert sent({"a": [1, 2.5, None], "b": "AA=="}, kind) == {"a": [1, 2.5, None], "b": "AA=="}


@pytest.mark.parametrize(
    "message", [{"ranges": "abc"}, {"ranges": [[1], [2]]}, {"ranges": 5}, {"ranges": {"a": 1}}, [1], 5, {"header": 1}]
)
def test_a_message_that_is_not_of_its_type_is_sent_as_it_is(message: Any) -> None:
    assert sent(message, "sensor_msgs/LaserScan") == message


@pytest.mark.parametrize("message", [{"data": [300]}, {"data": [1.5, "a"]}, {"data": None}])
def test_numbers_beyond_their_type_stay_a_plain_list(message: Any) -> None:
    assert sent(message, "nav_msgs/OccupancyGrid") == message


@pytest.mark.parametrize("data", ["not base64!", [256], {"a": 1}])
def test_bytes_that_are_none_stay_as_they_are(data: Any) -> None:
    assert sent({"data": data}, "sensor_msgs/Image") == {"data": data}
