"""Throttling and queues of subscriptions."""

import itertools
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ppaas.errors import MalformedMessage, UnknownType
from ppaas.wire.operations import RefusedOperation
from ppaas.wire.rosbridge import RosbridgeSession


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
