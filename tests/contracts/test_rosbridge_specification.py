"""Each clause of the specification of rosbridge v2 has a test named after it, with rosbridge_suite's behaviour.

The clauses are those of ``ROSBRIDGE_PROTOCOL.md`` on the branch ``ros2`` of ``RobotWebTools/rosbridge_suite``; ``old``
marks those of earlier editions, which clients still use. The rule: what rosbridge_suite takes, the cloud takes; what it
refuses, the cloud refuses with a text that says what to do; it never says nothing. Where the cloud deviates, the test
says so. How messages are read, clause 4.6 among it, is tested in ``test_rosbridge_messages.py``.

Members of the kind "rosbridge as its clients speak it": roslib writes ids like ``call_service:/x:1``, no id, and no
``args``; roslibpy writes nulls for what is not set; ROS# writes binary frames and a ``fragment_size`` of 2147483647;
rosbridge2cpp writes -1 for what is not set; roslibrust counts its ids; C# writers begin with a byte order mark.
"""

import base64
import io
import json
import random
from typing import Any

import pytest
from PIL import Image

from engine.protocols import robot_link
from ppaas.wire.operations import CLIENT_OPERATIONS
from tests.support.endpoints.still_place import StillClient, StillPlace, delivered, error_of, says

CALL = {"op": "call_service", "service": "/rosapi/topic_type", "args": {"topic": "/goal"}}
GOAL = {"op": "send_action_goal", "action": "/move_base", "action_type": "move_base_msgs/action/MoveBase"}


# -- 1. Message envelope -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "frame", ["", "x", "[]", "7", "null", '{"id": "a"}', '{"op": 7}', '{"op": null}', '{"op": "x"}']
)
async def test_1_a_message_is_an_object_with_a_known_op(client: StillClient, frame: str) -> None:
    client.send(frame)
    error_of(client.received())


async def test_1_an_unknown_op_is_refused_with_the_known_ones(client: StillClient) -> None:
    frame = error_of(says(client, op="example", id="fred"))
    assert frame["id"] == "fred"
    assert all(op in frame["msg"] for op in CLIENT_OPERATIONS)


@pytest.mark.parametrize("identity", ["fred", "", "call_service:/x:1", 0, 7, -1, 2**40])
async def test_1_an_id_is_a_string_or_an_integer_and_comes_back_as_it_came(
    client: StillClient, place: StillPlace, identity: str | int
) -> None:
    assert says(client, **CALL, id=identity)[0]["id"] == identity
    assert error_of(says(client, op="publish", topic="/nowhere", id=identity), "not-found")["id"] == identity
    client.say(op="subscribe", topic="/map", id=identity)
    client.say(op="unsubscribe", topic="/map", id=identity)
    place.publish_json("map", {})
    assert client.received() == []


@pytest.mark.parametrize("frame", [{}, {"id": None}])
async def test_1_an_id_may_be_left_out_or_null(client: StillClient, frame: dict[str, None]) -> None:
    [answer] = says(client, **CALL, **frame)
    assert answer["result"] is True and answer["id"] is None


async def test_1_a_string_and_a_number_are_different_ids(client: StillClient, place: StillPlace) -> None:
    client.say(op="subscribe", topic="/map", id=1)
    client.say(op="unsubscribe", topic="/map", id="1")
    place.publish_json("map", {})
    assert [frame["op"] for frame in client.received()] == ["publish"]


async def test_1_unknown_fields_of_an_operation_are_ignored(client: StillClient) -> None:
    assert says(client, **CALL, qos={"depth": 1}, png="no", message_intervall=0.1)[0]["result"] is True


@pytest.mark.parametrize(
    "operation",
    [
        CALL | {"service": 7}, CALL | {"timeout": "5"}, CALL | {"args": "x"}, {"op": "call_service"},
        CALL | {"service": "a b"}, CALL | {"type": 3},
    ],
)  # fmt: skip
async def test_1_a_call_that_cannot_be_read_is_answered_with_its_id(
    client: StillClient, operation: dict[str, Any]
) -> None:
    [answer] = says(client, **operation, id=9)
    assert (answer["op"], answer["result"], answer["id"]) == ("service_response", False, 9)
    assert isinstance(answer["values"], str) and answer["values"]


@pytest.mark.parametrize(
    "operation",
    [
        GOAL | {"action": 7}, GOAL | {"action_type": None}, GOAL | {"feedback": "yes"}, GOAL | {"args": 7},
        {"op": "send_action_goal"}, GOAL | {"action": "a b"}, GOAL | {"action_type": "?"}, GOAL | {"action": "fly"},
    ],
)  # fmt: skip
async def test_1_a_goal_that_cannot_be_read_ends_with_one_result_with_its_id(
    client: StillClient, place: StillPlace, operation: dict[str, Any]
) -> None:
    [result] = says(client, **operation, id=9)
    assert (result["op"], result["result"], result["status"], result["id"]) == ("action_result", False, 0, 9)
    assert isinstance(result["values"], str) and result["values"]
    assert delivered(place) == []


@pytest.mark.parametrize("between", ["", "\n", " \r\n\t"])
async def test_1_several_messages_in_one_frame_are_each_taken(client: StillClient, between: str) -> None:
    """As rosbridge_suite does; but a message must not be spread over frames, other than by ``fragment``."""
    frames = [CALL | {"id": 1}, {"op": "publish", "topic": "/nowhere", "id": 2}, CALL | {"id": 3}]
    client.send(between.join(map(json.dumps, frames)))
    assert [frame["id"] for frame in client.received()] == [1, 2, 3]
    client.send(json.dumps(CALL)[:10])
    error_of(client.received())


# -- 2. Operation summary ----------------------------------------------------------------------------------------------

TO_SERVER = (
    "fragment", "advertise", "unadvertise", "publish", "subscribe", "unsubscribe", "advertise_service",
    "unadvertise_service", "call_service", "service_response", "advertise_action", "unadvertise_action",
    "send_action_goal", "cancel_action_goal", "action_feedback", "action_result",
)  # fmt: skip


async def test_2_the_operations_are_those_of_the_specification() -> None:
    assert set(TO_SERVER) <= set(CLIENT_OPERATIONS)


@pytest.mark.parametrize(
    "op", ["png", "advertise_action", "unadvertise_action", "action_feedback", "action_result", "status", "auth"]
)
async def test_2_any_other_operation_is_refused_with_a_reason(client: StillClient, op: str) -> None:
    if op not in CLIENT_OPERATIONS:
        assert error_of(says(client, op=op, id="x"))["id"] == "x"


async def test_a_client_that_tries_to_log_in_is_told_how_whatever_its_status_level(place: StillPlace) -> None:
    """``auth`` of rosauth, with the fields that roslib and roslibpy send; rosbridge_suite of ROS 2 does not know it.

    A socket is logged in by its handshake, so that no stranger has one; a MAC of one secret for all is not taken.
    """
    silent = StillClient(place, level="none")
    mac = {"mac": "19d9", "client": "c", "dest": "d", "rand": "r", "t": 0, "level": "admin", "end": 0}
    silent.send(json.dumps({"op": "auth", "id": 4} | mac))
    frame = error_of(silent.received())
    assert frame["id"] == 4
    for way in ("Authorization: Bearer TOKEN", "ws://USER:TOKEN@HOST", "ticket", "&token=TOKEN"):
        assert way in frame["msg"]
    assert says(silent, op="publish", topic="/nowhere") == []
    silent.session.end()


# -- 3.1 Data encoding and transformation ------------------------------------------------------------------------------


def fragments(text: str, size: int) -> list[dict[str, Any]]:
    pieces = [text[begin : begin + size] for begin in range(0, len(text), size)]
    return [
        {"op": "fragment", "id": "f", "data": piece, "num": number, "total": len(pieces)}
        for number, piece in enumerate(pieces)
    ]


async def test_3_1_1_a_message_in_fragments_is_that_message(client: StillClient) -> None:
    for fragment in reversed(fragments(json.dumps(CALL | {"id": "c"}), 20)):
        client.say(**fragment)
    [answer] = client.received()
    assert (answer["result"], answer["id"]) == (True, "c")


@pytest.mark.parametrize("wrong", [{"id": None}, {"num": 9}, {"num": -1}, {"data": None}, {"total": 0}])
async def test_3_1_1_an_invalid_fragment_is_refused(client: StillClient, wrong: dict[str, Any]) -> None:
    [frame] = says(client, **fragments("x" * 40, 20)[0] | wrong)
    assert (frame["op"], frame["level"]) == ("status", "error")


@pytest.mark.parametrize("compression", ["none", "", None])
@pytest.mark.parametrize("size", [1, 2147483647, None])
async def test_3_1_2_to_3_1_4_no_compression_and_any_fragment_size_are_taken(
    client: StillClient, place: StillPlace, compression: str | None, size: int | None
) -> None:
    assert says(client, **CALL, compression=compression, fragment_size=size)[0]["result"] is True
    client.say(op="subscribe", topic="/map", compression=compression, fragment_size=size)
    place.publish_json("map", {"n": 1})
    assert client.received() == [{"op": "publish", "topic": "/map", "msg": {"n": 1}}]


async def test_3_1_4_cbor_is_a_binary_frame_with_typed_arrays(client: StillClient, place: StillPlace) -> None:
    client.say(op="subscribe", topic="/map", compression="cbor", fragment_size=1024)
    place.publish_json("map", {"data": [0, -1, 100] * 1000})
    [frame] = client.received()
    assert (frame["op"], frame["topic"]) == ("publish", "/map")
    assert (frame["msg"]["data"].tag, frame["msg"]["data"].value) == (72, b"\0\xff\x64" * 1000)


async def test_3_1_2_png_is_an_operation_with_the_message_as_an_image(client: StillClient, place: StillPlace) -> None:
    client.say(op="subscribe", topic="/map", compression="png")
    place.publish_json("map", {"n": 1})
    [frame] = client.received()
    assert in_png(frame) == {"op": "publish", "topic": "/map", "msg": {"n": 1}}


@pytest.mark.parametrize("ros2", [False, True])
async def test_3_1_4_cbor_raw_has_the_time_of_sending_and_the_bytes_of_the_message(
    client: StillClient, place: StillPlace, ros2: bool
) -> None:
    """In rosbridge_suite of ROS 1 the bytes are those of ROS 1, in that of ROS 2 CDR: here the type tells."""
    kind = "nav_msgs/msg/OccupancyGrid" if ros2 else "nav_msgs/OccupancyGrid"
    client.say(op="subscribe", topic="/map", type=kind, compression="cbor-raw")
    place.publish_json("map", {"data": [0, -1, 100]})
    [frame] = client.received()
    content = frame["msg"]
    assert (frame["op"], frame["topic"], set(content)) == ("publish", "/map", {"secs", "nsecs", "bytes"})
    assert content["secs"] > 1_000_000_000 and content["bytes"].endswith(b"\3\0\0\0\0\xff\x64")
    assert content["bytes"].startswith(b"\0\1\0\0") == ros2


@pytest.mark.parametrize(
    ("topic", "compression", "kind", "reason"),
    [
        ("/map", "zip", None, "'zip'"),
        ("/move_base/result", "cbor-raw", "move_base_msgs/msg/MoveBaseActionResult", "MoveBaseActionResult"),
    ],
)  # fmt: skip
async def test_3_4_4_json_is_sent_with_a_warning_if_the_compression_cannot_be_had(
    client: StillClient, place: StillPlace, topic: str, compression: str, kind: str | None, reason: str
) -> None:
    [warning] = says(client, op="subscribe", topic=topic, compression=compression, type=kind)
    assert (warning["level"], reason in warning["msg"], "JSON is sent" in warning["msg"]) == ("warning", True, True)
    place.publish_json(topic.strip("/"), {"n": 1})
    assert client.received() == [{"op": "publish", "topic": topic, "msg": {"n": 1}}]


def in_png(frame: dict[str, Any]) -> dict[str, Any]:
    """Return the operation in the image of a frame."""
    assert frame["op"] == "png"
    made: dict[str, Any] = json.loads(Image.open(io.BytesIO(base64.b64decode(frame["data"]))).tobytes())
    return made


def whole(frames: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the frame of some fragments, as a client puts it together."""
    assert [(frame["op"], frame["num"], frame["total"]) for frame in frames] == [
        ("fragment", number, len(frames)) for number in range(len(frames))
    ]
    assert len({frame["id"] for frame in frames}) == 1
    made: dict[str, Any] = json.loads("".join(frame["data"] for frame in frames))
    return made


@pytest.mark.parametrize("compression", ["none", "png"])
async def test_3_4_4_a_message_longer_than_fragment_size_comes_in_fragments(
    client: StillClient, other: StillClient, place: StillPlace, compression: str
) -> None:
    cells = random.Random(1).choices(range(-1, 101), k=20_000)
    client.say(op="subscribe", topic="/map", compression=compression, fragment_size=2048)
    other.say(op="subscribe", topic="/map", compression=compression)
    place.publish_json("map", {"data": cells})
    frames = client.received()
    assert len(frames) > 10 and all(len(frame["data"]) <= 2048 for frame in frames)
    frame = whole(frames)
    assert frame == other.received()[0]
    frame = frame if compression == "none" else in_png(frame)
    assert frame == {"op": "publish", "topic": "/map", "msg": {"data": cells}}


async def test_3_4_4_the_least_fragment_size_of_several_subscriptions_counts(
    client: StillClient, place: StillPlace
) -> None:
    for number, size in enumerate((0, 4096, 2048, 2147483647)):
        client.say(op="subscribe", topic="/map", id=f"s{number}", fragment_size=size)
    place.publish_json("map", {"data": "x" * 4000})
    assert len(client.received()[0]["data"]) == 2048


async def test_3_4_8_a_long_response_comes_in_fragments(client: StillClient, place: StillPlace) -> None:
    client.say(op="call_service", service="/make_plan", id="c", fragment_size=1024, args={})
    [call] = place.far.take(robot_link.ServiceCall)
    place._calls.end(call.call, json.dumps({"text": "y" * 5000}).encode())
    answer = whole(client.received())
    assert (answer["id"], answer["result"], answer["values"]) == ("c", True, {"text": "y" * 5000})


async def test_3_1_a_binary_frame_is_json(client: StillClient) -> None:
    client.send(json.dumps(CALL).encode())
    assert client.received()[0]["result"] is True
    client.send(b"\xff\xfe{")
    assert "must be JSON in UTF-8, CBOR" in error_of(client.received())["msg"]


async def test_3_1_bson_is_refused_by_its_name(client: StillClient) -> None:
    client.send(b"\x12\0\0\0\x02op\0\x05\0\0\0stop\0\0")
    assert "BSON is not supported" in error_of(client.received())["msg"]


@pytest.mark.parametrize("mark", ["\ufeff", "\ufeff \n", ""])
async def test_3_1_a_byte_order_mark_and_white_space_are_skipped(client: StillClient, mark: str) -> None:
    client.send(mark + json.dumps(CALL) + "\r\n")
    assert client.received()[0]["result"] is True


@pytest.mark.parametrize(
    ("word", "value"),
    [("NaN", None), ("Infinity", None), ("-Infinity", None), ("1e400", None), ("-1e999", None), ("1e300", 1e300)],
)
async def test_3_1_numbers_that_are_not_finite_are_null(
    client: StillClient, place: StillPlace, word: str, value: float | None
) -> None:
    client.send(f'{{"op": "publish", "topic": "/goal", "msg": {{"a": [{word}, NaN]}}}}')
    assert client.received() == []
    assert delivered(place) == [("goal", {"a": [value, None]})]


# -- older editions: 3.2 status messages -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("level", "heard"),
    [("none", []), ("error", ["error"]), ("warning", ["error", "warning"]), ("info", ["error", "warning"])],
)
async def test_old_3_2_1_set_level_selects_the_status_messages(
    client: StillClient, level: str, heard: list[str]
) -> None:
    assert says(client, op="set_level", level=level, id=None) == []
    found = says(client, op="publish", topic="/nowhere") + says(client, op="subscribe", topic="/chatter")
    assert [frame["level"] for frame in found] == heard


async def test_old_3_2_1_another_level_is_refused(client: StillClient) -> None:
    assert error_of(says(client, op="set_level", level="loud", id="l"))["id"] == "l"


async def test_old_3_2_2_a_status_has_the_id_of_the_operation_that_caused_it(client: StillClient) -> None:
    for frame in ({"op": "publish", "topic": "a b"}, {"op": "subscribe", "topic": ""}, {"op": "advertise", "topic": 3}):
        assert error_of(says(client, **frame, id=5))["id"] == 5


# -- 4. Further considerations -----------------------------------------------------------------------------------------


async def test_4_1_introspection_is_a_service_of_rosapi_and_no_pseudo_service(
    client: StillClient, place: StillPlace
) -> None:
    [answer] = says(client, op="call_service", service="/rosapi/topics", id="t")
    assert "/map" in answer["values"]["topics"]
    assert says(client, op="call_service", service="/rosbridge/topics") == []
    [call] = place.far.take(robot_link.ServiceCall)  # the clone answers that it does not exist
    assert call.service == "rosbridge/topics"


async def test_4_3_latched_messages_reach_later_subscribers(client: StillClient, other: StillClient) -> None:
    client.say(op="advertise", topic="/chatter", type="std_msgs/String", latch=True)
    client.say(op="publish", topic="/chatter", msg={"data": "x"})
    other.say(op="subscribe", topic="/chatter")
    assert other.received() == [{"op": "publish", "topic": "/chatter", "msg": {"data": "x"}}]
