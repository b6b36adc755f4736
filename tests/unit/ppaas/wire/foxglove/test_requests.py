"""Requests of Foxglove's clients."""

import json
import struct
from typing import Any

import msgspec
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage
from ppaas.wire.foxglove import requests
from ppaas.wire.foxglove.requests import RefusedCall, read_request

IDS = st.integers(0, 2**32 - 1)
OPERATIONS: list[dict[str, Any]] = [
    {"op": "subscribe", "subscriptions": [{"id": 1, "channelId": 2}]},
    {"op": "unsubscribe", "subscriptionIds": [1]},
    {"op": "advertise", "channels": [{"id": 1, "topic": "/a", "encoding": "json", "schemaName": "b/C"}]},
    {"op": "unadvertise", "channelIds": [1]},
    {"op": "getParameters", "parameterNames": [], "id": "a"},
    {"op": "setParameters", "parameters": [{"name": "/a", "value": 1.5, "type": "float64"}, {"name": "/b"}]},
    {"op": "subscribeParameterUpdates", "parameterNames": ["/a"]},
    {"op": "unsubscribeParameterUpdates", "parameterNames": ["/a"]},
    {"op": "subscribeConnectionGraph"},
    {"op": "unsubscribeConnectionGraph"},
    {"op": "fetchAsset", "uri": "package://a/b.stl", "requestId": 3},
]


@pytest.mark.parametrize("operation", OPERATIONS, ids=lambda one: one["op"])
def test_each_operation_is_read(operation: dict[str, Any]) -> None:
    read = read_request(json.dumps(operation))
    assert isinstance(read, requests.Request)
    assert {
        name: value for name, value in json.loads(msgspec.json.encode(read)).items() if value is not None
    } == operation


def test_the_list_of_operations_is_that_of_the_types() -> None:
    assert [operation["op"] for operation in OPERATIONS] == list(requests.OPERATIONS)


def test_an_operation_of_another_version_is_ignored() -> None:
    assert read_request('{"op": "playbackControl", "speed": 1}') is None


@given(IDS, st.binary(max_size=64))
def test_messages_are_read(channel: int, data: bytes) -> None:
    assert read_request(struct.pack("<BI", 1, channel) + data) == requests.MessageData(channel, data)


@given(IDS, IDS, st.text(max_size=8), st.binary(max_size=64))
def test_calls_are_read(service: int, call: int, encoding: str, data: bytes) -> None:
    named = encoding.encode()
    frame = struct.pack("<BIII", 2, service, call, len(named)) + named + data
    assert read_request(frame) == requests.FoxgloveServiceCall(service, call, encoding, data)


@pytest.mark.parametrize(
    ("frame", "why"),
    [
        (b"", "empty"),
        (b"\x01\x00", "too short"),
        (b"\x09aaaa", "unknown binary operation 9"),
        (struct.pack("<BII", 2, 1, 1), "too short"),
        ("", "not an operation"),
        ("[]", "not an operation"),
        ('{"op": "subscribe", "subscriptions": [{"id": -1, "channelId": 1}]}', r"subscriptions\[0\]\.id|\$"),
        ('{"op": "subscribe", "subscriptions": [{"id": 4294967296, "channelId": 1}]}', "<= 4294967295"),
        ('{"op": "unsubscribe", "subscriptionIds": "all"}', "subscriptionIds"),
        ("[" * 100_000, "not an operation"),
    ],
)
def test_other_frames_are_refused_with_the_reason(frame: str | bytes, why: str) -> None:
    with pytest.raises(MalformedMessage, match=why):
        read_request(frame)


VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=8,
)
FIELDS = st.sampled_from([*{key for operation in OPERATIONS for key in operation} - {"op"}, "channels"])
FRAMES = (
    st.binary(max_size=64)
    | st.text(max_size=64)
    | st.tuples(st.sampled_from([*requests.OPERATIONS, "other"]), st.dictionaries(FIELDS, VALUES, max_size=3)).map(
        lambda made: json.dumps({"op": made[0]} | made[1])
    )
)


@given(FRAMES)
@example('{"op": "\ud800"}')
def test_any_frame_is_read_or_refused(frame: str | bytes) -> None:
    try:
        read_request(frame)
    except MalformedMessage as error:
        assert str(error)


@pytest.mark.parametrize(
    ("length", "rest", "why"), [(2**31, b"", "encoding of a call"), (3, b"js", "2 follow"), (1, b"\xff", "no text")]
)
def test_a_call_that_cannot_be_read_keeps_its_ids(length: int, rest: bytes, why: str) -> None:
    refused = read_request(struct.pack("<BIII", 2, 3, 4, length) + rest)
    assert isinstance(refused, RefusedCall)
    assert (refused.service_id, refused.call_id) == (3, 4)
    assert isinstance(refused.error, MalformedMessage) and why in str(refused.error)
