"""Server side of rosbridge: frames as operations, and subscriptions."""

import itertools
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage, NotFound, QuotaExceeded, UnknownType
from ppaas.wire import operations
from ppaas.wire.operations import CallService, Publish, RefusedOperation
from ppaas.wire.rosbridge import MAX_SHOWN, MAX_SUBSCRIPTIONS, RosbridgeSession, decode_operation

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


def refused(frame: str) -> RefusedOperation:
    operation = decode_operation(frame)
    assert isinstance(operation, RefusedOperation)
    return operation


@pytest.mark.parametrize("value", ["Infinity", "1"])
def test_the_operation_id_and_name_of_a_refused_frame_are_known(value: str) -> None:
    frame = refused(f'{{"op":"call_service","service":"/x","id":7,"timeout":"5","args":[{value}]}}')
    assert (frame.op, frame.id, frame.name) == ("call_service", 7, "/x")
    assert "`$.timeout`" in str(frame.error)


@pytest.mark.parametrize("identity", ["1.5", "true", "null", "[1]", "{}", json.dumps("x" * MAX_SHOWN), '"\\ud800"'])
def test_an_id_that_is_no_short_string_or_integer_is_not_sent_back(identity: str) -> None:
    assert refused(f'{{"op":"subscribe","id":{identity}}}').id is None


@pytest.mark.parametrize("frame", ["[]", "[NaN]", "7", "{}", '{"op":null}', '{"op":"' + "x" * 5000 + '"}', "{]"])
def test_a_frame_without_a_known_operation_is_refused_with_a_short_text(frame: str) -> None:
    found = refused(frame)
    assert (found.id, found.name) == (None, "")
    assert len(str(found.error)) < 500


def test_the_content_of_a_valid_frame_is_not_touched() -> None:
    frame = '{"op":"publish","topic":"/a","msg":{"x": 1.50, "x": "\\u0041"}}'
    operation = decode_operation(frame)
    assert isinstance(operation, Publish) and bytes(operation.msg) == b'{"x": 1.50, "x": "\\u0041"}'


@pytest.mark.parametrize(("service", "identity"), [("/a#5", "5"), ("/a#", None), ("/a", None), ("/a#5#6", "5#6")])
def test_an_id_after_the_name_of_a_service_is_its_id_unless_it_has_one(service: str, identity: str | None) -> None:
    operation = decode_operation(json.dumps({"op": "call_service", "service": service}))
    assert isinstance(operation, CallService) and operation.id == identity
    named = decode_operation(json.dumps({"op": "call_service", "service": service, "id": 0}))
    assert isinstance(named, CallService) and named.id == 0


class Listener:
    """A session, and the frames that it has sent."""

    def __init__(self, *subscriptions: dict[str, object]) -> None:
        self.session = RosbridgeSession()
        self.sent: list[tuple[float, int]] = []
        for number, fields in enumerate(subscriptions):
            self.session.receive(json.dumps({"op": "subscribe", "topic": "a", "id": str(number)} | fields))

    def publish(self, number: int, now: float) -> None:
        """Let time pass until now, then publish."""
        self.wait(now)
        self._note(now, self.session.publish("a", str(number).encode(), now))

    def wait(self, until: float) -> None:
        """Send what becomes due, each at its time."""
        while (due := self.session.next_due()) is not None and due <= until:
            self._note(due, (frame for _, frame in self.session.due(due)))

    def _note(self, now: float, frames: object) -> None:
        self.sent += [(round(now, 6), json.loads(frame)["msg"]) for frame in frames]  # type: ignore[attr-defined]


def test_early_message_is_sent_at_the_end_of_the_interval() -> None:
    listener = Listener({"throttle_rate": 100})
    for number, now in enumerate((0.0, 0.02, 0.04)):
        listener.publish(number, now)
    listener.wait(1.0)
    assert listener.sent == [(0.0, 0), (0.1, 2)]
    listener.publish(3, 5.0)
    assert listener.sent[-1] == (5.0, 3)


def test_queued_messages_are_sent_one_by_one_in_order() -> None:
    listener = Listener({"throttle_rate": 100, "queue_length": 2})
    for number in range(5):
        listener.publish(number, number * 0.01)
    listener.wait(1.0)
    assert listener.sent == [(0.0, 0), (0.1, 3), (0.2, 4)]


def test_subscriptions_share_the_shortest_interval_and_longest_queue() -> None:
    listener = Listener({"throttle_rate": 1000}, {"throttle_rate": 100, "queue_length": 1}, {"throttle_rate": 500})
    for number in range(30):
        listener.publish(number, number * 0.01)
    listener.wait(1.0)
    assert [now for now, _ in listener.sent] == [0.0, 0.1, 0.2, 0.3]
    listener.session.receive('{"op":"unsubscribe","topic":"a","id":"1"}')
    listener.publish(30, 2.0)
    listener.publish(31, 2.1)
    listener.wait(9.0)
    assert listener.sent[-2:] == [(2.0, 30), (2.5, 31)]


def test_pending_messages_are_dropped_with_the_last_subscription() -> None:
    listener = Listener({"throttle_rate": 100})
    listener.publish(0, 0.0)
    listener.publish(1, 0.01)
    listener.session.receive('{"op":"unsubscribe","topic":"a"}')
    assert listener.session.next_due() is None
    assert list(listener.session.due(9.0)) == []


def test_subscription_with_the_same_id_replaces_the_first() -> None:
    session = RosbridgeSession()
    session.receive('{"op":"subscribe","topic":"/a","id":"1","throttle_rate":60000}')
    session.receive('{"op":"subscribe","topic":"a","id":"1"}')
    frames = [frame for now in (0.0, 0.1) for frame in session.publish("a", b"1", now)]
    assert [json.loads(frame)["topic"] for frame in frames] == ["a", "a"]
    session.receive('{"op":"unsubscribe","topic":"a","id":"1"}')
    assert session.subscribed() == frozenset()


def test_times_are_spelled_like_the_requested_type() -> None:
    session = RosbridgeSession()
    for topic, kind in (("/one", "std_msgs/Header"), ("/two", "std_msgs/msg/Header")):
        session.receive(json.dumps({"op": "subscribe", "topic": topic, "type": kind}))
    stamp = b'{"stamp":{"secs":1,"nsecs":2}}'
    assert json.loads(next(session.publish("one", stamp, 0.0)))["msg"] == {"stamp": {"secs": 1, "nsecs": 2}}
    assert json.loads(next(session.publish("two", stamp, 0.0)))["msg"] == {"stamp": {"sec": 1, "nanosec": 2}}


@pytest.mark.parametrize("fields", [{"throttle_rate": "often"}, {"queue_length": 1.5}, {"queue_length": "1"}])
def test_an_invalid_rate_is_refused_with_its_id(fields: dict[str, object]) -> None:
    refused = RosbridgeSession().receive(json.dumps({"op": "subscribe", "topic": "a", "id": "s1"} | fields))
    assert isinstance(refused, RefusedOperation)
    assert (type(refused.error), refused.id, refused.name) == (MalformedMessage, "s1", "a")


@pytest.mark.parametrize("number", [-1, -2147483648, None, 0])
def test_a_negative_or_null_rate_and_queue_count_as_zero(number: int | None) -> None:
    listener = Listener({"throttle_rate": number, "queue_length": number})
    for message, now in enumerate((0.0, 0.001)):
        listener.publish(message, now)
    assert listener.sent == [(0.0, 0), (0.001, 1)]
    assert listener.session.queue_length("a", 10) == 10


@pytest.mark.parametrize(
    ("kind", "matrix", "seconds"),
    [
        ("sensor_msgs/CameraInfo", "K", "secs"),
        ("sensor_msgs/msg/CameraInfo", "k", "sec"),
        ("sensor_msgs/msg/Image", "K", "sec"),
        (None, "K", "secs"),
    ],
)
def test_a_camera_info_is_spelled_like_the_requested_type(kind: str | None, matrix: str, seconds: str) -> None:
    session = RosbridgeSession()
    session.receive(json.dumps({"op": "subscribe", "topic": "/info", "type": kind}))
    payload = b'{"header":{"stamp":{"secs":1}},"K":[1.0],"distortion_model":"\\"K\\":"}'
    message = json.loads(next(session.publish("info", payload, 0.0)))["msg"]
    assert message == {"header": {"stamp": {seconds: 1}}, matrix: [1.0], "distortion_model": '"K":'}


def test_type_names_are_validated() -> None:
    from ppaas.wire.names import is_ros2_type, ros1_type

    assert ros1_type("a_msgs/B") == ros1_type("a_msgs/msg/B") == ros1_type("a_msgs/action/B") == "a_msgs/B"
    assert is_ros2_type("a/srv/B") and not is_ros2_type("a/B") and not is_ros2_type(None)
    for bad in ("", "B", "a/b/c", "a/msg/", "a b/C", "a/msg/B\n", "ä/B", "x" * 300):
        with pytest.raises(UnknownType):
            ros1_type(bad)


@given(
    st.lists(st.floats(0.0, 0.3), min_size=1, max_size=40),
    st.sampled_from([10, 100, 250]),
    st.integers(0, 4),
)
def test_last_message_always_arrives_within_the_rate(gaps: list[float], rate: int, queue: int) -> None:
    listener = Listener({"throttle_rate": rate, "queue_length": queue})
    for number, now in enumerate(itertools.accumulate(gaps)):
        listener.publish(number, now)
    listener.wait(1e6)
    times, numbers = zip(*listener.sent, strict=True)
    assert numbers[-1] == len(gaps) - 1
    assert list(numbers) == sorted(set(numbers))
    assert all(later - earlier >= rate / 1000.0 - 1e-5 for earlier, later in itertools.pairwise(times))
