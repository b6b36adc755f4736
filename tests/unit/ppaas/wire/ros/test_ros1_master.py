"""XML-RPC and the state of a master of ROS 1."""

import xmlrpc.client
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import InvalidInput, MalformedMessage, MessageTooLarge, Unavailable
from ppaas.wire.ros.ros1_master import (
    FAILURE,
    MAX_CALL,
    MAX_NAMES,
    SUCCESS,
    pack_call,
    pack_fault,
    pack_response,
    read_state,
    read_types,
    unpack_call,
    unpack_response,
)

TEXT = st.text(st.characters(min_codepoint=32, exclude_categories=["Cs"]), max_size=20).filter(
    lambda text: "\r" not in text
)
VALUES = st.recursive(st.integers(-(2**31), 2**31 - 1) | TEXT | st.booleans(), st.lists, max_leaves=10)


@given(st.from_regex(r"[a-z]\w{0,9}", fullmatch=True), st.lists(VALUES, max_size=4))
def test_calls_are_read_as_they_were_written(method: str, arguments: list[object]) -> None:
    assert unpack_call(pack_call(method, *arguments)) == (method, tuple(arguments))


@given(TEXT, VALUES)
def test_responses_are_read_as_they_were_written(text: str, value: object) -> None:
    assert unpack_response(pack_response(SUCCESS, text, value)) == value


def test_a_failure_is_told_with_its_text() -> None:
    with pytest.raises(Unavailable, match="no such node"):
        unpack_response(pack_response(FAILURE, "no such node", 0))
    with pytest.raises(Unavailable, match="the call was refused: not a call"):
        unpack_response(pack_fault("not a call"))


def bomb(depth: int) -> bytes:
    """Return a document whose entities grow by ten with each level."""
    entities = "".join(f'<!ENTITY e{n} "{f"&e{n - 1};" * 10}">' for n in range(1, depth))
    head = f'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY e0 "a">{entities}]>'
    return f"{head}<methodCall><methodName>&e{depth - 1};</methodName></methodCall>".encode()


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"", "no XML-RPC"),
        (b"<methodCall>", "no XML-RPC"),
        (b"\xff", "no XML-RPC"),
        (b"<methodResponse><params><param><value><int>1</int></value></param></params></methodResponse>", "no method"),
        (bomb(9), "declarations of XML"),
        ('<?xml version="1.0" encoding="utf-16"?><methodCall/>'.encode("utf-16"), "no XML-RPC"),
        (b"<methodCall><methodName>a</methodName><params><param><value><int>x</int></value></param></params></methodCall>",
         "no XML-RPC"),
    ],
)  # fmt: skip
def test_what_is_no_call_is_refused(data: bytes, text: str) -> None:
    with pytest.raises(MalformedMessage, match=text):
        unpack_call(data)


def test_sizes_are_limited() -> None:
    with pytest.raises(MessageTooLarge):
        unpack_call(bytes(MAX_CALL + 1))


@pytest.mark.parametrize("value", [7, [1, "two"], [[1, "text", 0]] * 2, {"a": 1}])
def test_what_is_no_response_of_ros_is_refused(value: object) -> None:
    with pytest.raises(InvalidInput, match="not a list of status, text and value"):
        unpack_response(xmlrpc.client.dumps((value,), methodresponse=True).encode())


def test_nodes_are_found_by_topic_and_service() -> None:
    state = read_state([[["/odom", ["/base", "/ekf"]]], [["/cmd_vel", ["/base"]]], [["/dock", ["/docker"]]]])
    assert state.publishers == {"/odom": {"/base", "/ekf"}}
    assert (state.subscribers, state.services) == ({"/cmd_vel": {"/base"}}, {"/dock": {"/docker"}})


def test_types_are_spelled_as_in_ros_2_and_old_names_of_one_are_known() -> None:
    types = read_types([["/odom", "nav_msgs/Odometry"], ["/tf", "tf/tfMessage"], ["/any", "*"]])
    assert types == {"/odom": "nav_msgs/msg/Odometry", "/tf": "tf2_msgs/msg/TFMessage", "/any": ""}


@pytest.mark.parametrize(
    "value",
    [
        0,
        [[], []],
        [[], [], 0],
        [[["/a"]], [], []],
        [[["/a", "/b"]], [], []],
        [[["/a", [1]]], [], []],
        [[[1, []]], [], []],
        [[["/a", []]] * (MAX_NAMES + 1), [], []],
    ],
)
def test_what_is_no_state_is_refused(value: Any) -> None:
    with pytest.raises(MalformedMessage):
        read_state(value)


@pytest.mark.parametrize("value", [0, [["/a"]], [["/a", 1]], ["/a"], [["/a", "b/C"]] * (MAX_NAMES + 1)])
def test_what_are_no_types_is_refused(value: Any) -> None:
    with pytest.raises(MalformedMessage):
        read_types(value)
