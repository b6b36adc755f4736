"""CBOR of rosbridge, in both directions."""

import base64
import json
import math
from typing import Any

import cbor2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage, MessageTooLarge, PPaaSError
from ppaas.wire.binary.binary_frame import BinaryFrame
from ppaas.wire.binary.cbor import ARRAY_TYPES, MAX_DEPTH, MAX_ITEMS, MAX_NUMBERS, cbor_frame, cbor_to_json, is_cbor

VALUES: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**64), 2**64 - 1) | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(), inner, max_size=5),
    max_leaves=20,
)  # fmt: skip


def read(value: object) -> Any:
    return json.loads(cbor_to_json(cbor2.dumps(value)))


@given(VALUES)
def test_cbor_of_a_value_is_read_as_its_json(value: Any) -> None:
    assert read(value) == value


@given(st.binary(max_size=50) | st.binary(max_size=50).map(lambda data: b"\xa1\x61a" + data))
def test_any_bytes_are_read_as_json_or_refused(data: bytes) -> None:
    try:
        json.loads(cbor_to_json(data))
    except PPaaSError as error:
        assert isinstance(error, MalformedMessage | MessageTooLarge)


@pytest.mark.parametrize(("tag", "kind"), ARRAY_TYPES.items())
def test_each_typed_array_is_a_list_of_its_numbers(tag: int, kind: str) -> None:
    numbers = np.array([0, 1, 7, 100]).astype(kind)
    assert read({"a": cbor2.CBORTag(tag, numbers.tobytes())}) == {"a": [0, 1, 7, 100]}


def test_numbers_that_are_not_finite_are_null_as_in_json() -> None:
    numbers = np.array([1.5, math.nan, -math.inf], "<f4")
    assert read({"a": cbor2.CBORTag(85, numbers.tobytes()), "b": math.inf}) == {"a": [1.5, None, None], "b": None}


@pytest.mark.parametrize("data", [b"ab\xff", cbor2.CBORTag(64, b"ab\xff"), cbor2.CBORTag(68, b"ab\xff")])
def test_byte_strings_are_base64(data: object) -> None:
    assert base64.b64decode(read({"data": data})["data"]) == b"ab\xff"


def test_an_undefined_value_is_null() -> None:
    assert read({"a": cbor2.undefined}) == {"a": None}


def test_the_tag_that_announces_cbor_may_precede_it() -> None:
    assert json.loads(cbor_to_json(b"\xd9\xd9\xf7" + cbor2.dumps({"op": "x"}))) == {"op": "x"}


def test_strings_of_indefinite_length_are_joined() -> None:
    assert json.loads(cbor_to_json(b"\xbf\x7f\x61o\x61p\xff\x9f\x01\xff\xff")) == {"op": [1]}


@pytest.mark.parametrize("tag", sorted({*range(0, 300), 1004, 43000, 55799} - {64, 68, *ARRAY_TYPES}))
def test_no_other_tag_is_read(tag: int) -> None:
    for content in (b"12345678", "1970-01-01", [1, 2], 5):
        with pytest.raises(MalformedMessage, match=f"tag {tag} of CBOR"):
            read({"a": cbor2.CBORTag(tag, content)})


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (cbor2.dumps({1: 2}), "key"),
        (cbor2.dumps({b"a": 2}), "key of CBOR must be a text"),
        (b"\xa1\x61a\xf0", "CBORSimpleValue"),
        (cbor2.dumps({"a": cbor2.CBORTag(85, b"123")}), "cut off"),
        (cbor2.dumps({"a": cbor2.CBORTag(85, [1.0])}), "not that of a typed array"),
        (b"\xa1\x61a", "not CBOR"),
        (b"\xa1\x61a\x5b\x7f\xff\xff\xff\xff\xff\xff\xff", "not CBOR"),
        (b"\xa1\x61a\x9b\x7f\xff\xff\xff\xff\xff\xff\xff", "not CBOR"),
        (b"\xa1\x61a" + b"\x81" * (MAX_DEPTH + 1), "depth"),
        (b"\xa1\x61\xff\x01", "not CBOR"),
    ],
)
def test_what_json_cannot_express_is_refused_with_the_reason(data: bytes, reason: str) -> None:
    with pytest.raises(MalformedMessage, match=reason):
        cbor_to_json(data)


def test_too_many_items_are_refused_before_they_are_decoded() -> None:
    with pytest.raises(MessageTooLarge, match="typed arrays"):
        cbor_to_json(b"\x9a\x00\xff\xff\xff" + b"\x80" * (MAX_ITEMS + 1))
    assert read([0] * (MAX_ITEMS - 1)) == [0] * (MAX_ITEMS - 1)


def test_too_many_numbers_in_typed_arrays_are_refused() -> None:
    half = cbor2.CBORTag(72, bytes(MAX_NUMBERS // 2))
    assert len(read([half, half])) == 2
    with pytest.raises(MessageTooLarge, match="typed arrays"):
        read([half, half, cbor2.CBORTag(72, b"\0")])


@pytest.mark.parametrize("frame", [b"", b'{"op":1}', b" {}", b"\xef\xbb\xbf{}", b"\x01", b"\x80", b"\xd9\xd9"])
def test_json_and_others_are_not_taken_for_cbor(frame: bytes) -> None:
    assert not is_cbor(frame)


@pytest.mark.parametrize("frame", [cbor2.dumps({}), cbor2.dumps({"op": 1}), b"\xbf\xff", b"\xd9\xd9\xf7\xa0"])
def test_a_map_in_cbor_is_recognized(frame: bytes) -> None:
    assert is_cbor(frame)


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
