"""Messages to robots."""

import json

from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, NotFound, Unavailable
from ppaas.wire.rapyuta.answers import MAX_ERROR, Frames, data_message, error_message, interface_status


def test_a_message_has_four_fields() -> None:
    frames = data_message("req", "std_msgs/String", "7", {"data": "hi"})
    assert json.loads(frames.text) == {
        "type": "DM",
        "data": {"iTag": "req", "type": "std_msgs/String", "msgID": "7", "msg": {"data": "hi"}},
    }
    assert frames.parts == ()


def test_bytes_follow_their_message_with_their_uuid() -> None:
    frames = data_message("img", "sensor_msgs/CompressedImage", "7", {"format": "png", "data": b"\1\2"})
    message = json.loads(frames.text)["data"]["msg"]
    assert message.keys() == {"format", "data*"}
    assert frames.parts == (message["data*"].encode() + b"\1\2",)
    assert len(message["data*"]) == 32
    forwarded = data_message("img", "sensor_msgs/CompressedImage", "7", b"zlib")
    assert forwarded.parts == (json.loads(forwarded.text)["data"]["msg*"].encode() + b"zlib",)


def test_a_status_is_of_an_interface() -> None:
    expected = {"type": "ST", "data": {"topic": "iu", "iTag": "req", "status": True}}
    assert json.loads(interface_status("req", active=True).text) == expected


def test_errors_of_the_robot_are_invalid_requests() -> None:
    assert json.loads(error_message(InvalidInput("no")).text) == {"type": "ER", "data": "Invalid Request: no"}
    assert json.loads(error_message(NotFound("node", "a b", ["x y"])).text)["data"].endswith("known: 'x y'")
    assert json.loads(error_message(Unavailable("full")).text)["data"] == "full"
    assert json.loads(error_message(InvalidInput("Invalid Request: no")).text)["data"] == "Invalid Request: no"
    assert len(json.loads(error_message(InvalidInput("x" * 9999)).text)["data"]) == MAX_ERROR


@given(st.binary(max_size=9), st.lists(st.binary(max_size=9)))
def test_packed_frames_are_unpacked(text: bytes, parts: list[bytes]) -> None:
    frames = Frames(text, tuple(parts))
    assert Frames.unpack(frames.packed()) == frames
