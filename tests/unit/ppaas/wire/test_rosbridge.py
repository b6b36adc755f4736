"""The server side of rosbridge, frame by frame."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage, NotFound, QuotaExceeded
from ppaas.wire import operations
from ppaas.wire.operations import RefusedOperation
from ppaas.wire.rosbridge import MAX_SUBSCRIPTIONS, RosbridgeSession

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)
OPS = ["publish", "subscribe", "unsubscribe", "call_service", "advertise", "unadvertise", "set_level", "fragment", "x"]


def test_published_message_is_unchanged() -> None:
    operation = RosbridgeSession().receive('{"op":"publish","topic":"/a","msg":{"data":  1.50}}')
    assert isinstance(operation, operations.Publish)
    assert bytes(operation.msg) == b'{"data":  1.50}'


def test_names_are_echoed_as_the_client_spelled_them() -> None:
    session = RosbridgeSession()
    session.receive('{"op":"subscribe","topic":"/map","id":"1"}')
    session.receive('{"op":"subscribe","topic":"map","id":"2"}')
    session.receive('{"op":"subscribe","topic":"/map","id":"3"}')
    frames = [json.loads(f) for f in session.publish("map", b'{"x":1}', 0.0)]
    assert sorted(f["topic"] for f in frames) == ["/map", "map"]
    assert all(f["op"] == "publish" and f["msg"] == {"x": 1} for f in frames)


def test_topic_is_received_until_its_last_subscription_ends() -> None:
    session = RosbridgeSession()
    session.receive('{"op":"subscribe","topic":"/a","id":"1"}')
    session.receive('{"op":"subscribe","topic":"/a","id":"2"}')
    session.receive('{"op":"unsubscribe","topic":"/a","id":"1"}')
    assert session.subscribed() == {"a"}
    session.receive('{"op":"unsubscribe","topic":"a"}')
    assert session.subscribed() == frozenset()
    assert list(session.publish("a", b"{}", 0.0)) == []


def test_throttle_rate_is_milliseconds_between_messages() -> None:
    session = RosbridgeSession()
    session.receive('{"op":"subscribe","topic":"a","throttle_rate":100}')
    sent = [bool(list(session.publish("a", b"{}", t))) for t in (0.0, 0.05, 0.1, 0.15, 0.21)]
    assert sent == [True, False, True, False, True]


def test_a_response_carries_the_id_and_the_service_as_called() -> None:
    session = RosbridgeSession()
    call = session.receive('{"op":"call_service","service":"/make_plan","id":"c:1","args":{"a":1}}')
    assert isinstance(call, operations.CallService)
    assert json.loads(session.answer(call, b'{"plan":1}')) == {
        "op": "service_response", "service": "/make_plan", "id": "c:1", "values": {"plan": 1}, "result": True,
    }  # fmt: skip
    refused = json.loads(session.refuse_call(call, NotFound("service", "make_plan")))
    assert refused["result"] is False
    assert "make_plan" in refused["values"]


def test_status_is_sent_only_to_a_client_with_a_status_level() -> None:
    session = RosbridgeSession()
    error = MalformedMessage("no")
    assert session.status(error) is None
    session.receive('{"op":"set_level","level":"warning"}')
    status = json.loads(session.status(error) or "")
    assert status == {"op": "status", "level": "error", "msg": "malformed-message: no", "id": None}
    assert json.loads(session.status(error, 7) or "")["id"] == 7
    session.receive('{"op":"set_level","level":"none"}')
    assert session.status(error) is None


@pytest.mark.parametrize(
    "frame",
    [
        "", "{", "[]", "null", "7", '"x"', '{"op":"nope"}', '{"topic":"a"}', '{"op":"publish","msg":{}}',
        '{"op":"publish","topic":7,"msg":{}}', '{"op":"subscribe","topic":"a b"}', '{"op":"subscribe","topic":""}',
        '{"op":"subscribe","topic":"a","throttle_rate":"1"}', '{"op":"set_level","level":"loud"}',
        '{"op":"subscribe","topic":"a\\",\\"msg"}', '{"op":"subscribe","topic":"' + "a" * 300 + '"}', "[" * 100_000,
        b"\xff\xfe\x00", '{"op":"subscribe","topic":"a"}{"op":"subscribe","topic":"b"}',
    ],
)  # fmt: skip
def test_an_invalid_operation_is_malformed_and_changes_nothing(frame: str | bytes) -> None:
    session = RosbridgeSession()
    session.receive('{"op":"subscribe","topic":"kept"}')
    refused = session.receive(frame)
    assert isinstance(refused, RefusedOperation)
    assert isinstance(refused.error, MalformedMessage)
    assert session.subscribed() == {"kept"}


def test_number_of_subscriptions_of_a_client_is_limited() -> None:
    session = RosbridgeSession()
    for number in range(MAX_SUBSCRIPTIONS):
        session.receive(json.dumps({"op": "subscribe", "topic": "a", "id": str(number)}))
    refused = session.receive('{"op":"subscribe","topic":"b","id":9}')
    assert isinstance(refused, RefusedOperation)
    assert (type(refused.error), refused.id) == (QuotaExceeded, 9)


@given(st.sampled_from(OPS), st.dictionaries(st.sampled_from(["topic", "msg", "id", "args", "service", "level"]), JSON))
def test_any_object_is_a_valid_operation_or_malformed(op: str, fields: dict[str, object]) -> None:
    operation = RosbridgeSession().receive(json.dumps({"op": op, **fields}))
    assert isinstance(operation, operations.Operation | RefusedOperation)


@given(st.binary(max_size=200))
def test_arbitrary_bytes_are_malformed(frame: bytes) -> None:
    assert isinstance(RosbridgeSession().receive(frame), RefusedOperation)
    assert isinstance(RosbridgeSession().receive_binary(frame), RefusedOperation)


@pytest.mark.parametrize("spelled", ["{}", "[1, NaN]", '"Tür"', '"T\\u00fcr"'])
def test_text_is_read_alike_as_characters_and_as_utf8(spelled: str) -> None:
    text = '\ufeff{"op": "publish", "topic": "/a", "msg": ' + spelled + "}"
    for frame in (text, text[1:]):
        assert RosbridgeSession().receive(frame) == RosbridgeSession().receive(frame.encode())
