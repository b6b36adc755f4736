"""Tests of topics that clients advertise to each other."""

import json

import pytest

from engine.sessions.place.client_topics import MAX_LATCHED_BYTES, MAX_TOPICS, ClientTopics
from ppaas.errors import Conflict, MalformedMessage, NotFound, QuotaExceeded
from ppaas.wire.own_topics import PRESENCE

STRING = "my_msgs/Text"


def test_topic_exists_while_a_client_advertises_it() -> None:
    topics = ClientTopics()
    for advertiser in ((1, "a"), (1, "b"), (2, None)):
        topics.advertise("chatter", STRING, advertiser, latch=False)
    topics.unadvertise("chatter", (1, "a"))
    assert topics.types() == {"chatter": STRING}
    topics.unadvertise("chatter", (1, None))
    with pytest.raises(NotFound):
        topics.unadvertise("chatter", (1, "b"))
    topics.leave(2)
    assert "chatter" not in topics and topics.type_of("chatter") is None


def test_a_topic_keeps_its_type() -> None:
    topics = ClientTopics()
    topics.advertise("chatter", STRING, (1, None), latch=False)
    with pytest.raises(Conflict, match=r"has type my_msgs/Text, not std_msgs/Bool"):
        topics.advertise("chatter", "std_msgs/Bool", (2, None), latch=False)
    topics.leave(1)
    topics.advertise("chatter", "std_msgs/Bool", (2, None), latch=False)


@pytest.mark.parametrize(("by_topic", "by_message", "kept"), [(0, 0, None), (1, 0, b"{}"), (0, 1, b"{}")])
def test_last_message_is_kept_if_latched(by_topic: int, by_message: int, kept: bytes | None) -> None:
    topics = ClientTopics()
    topics.advertise("chatter", STRING, (1, None), latch=bool(by_topic))
    topics.take("chatter", b"{}", latch=bool(by_message))
    assert topics.latched("chatter") == kept
    topics.leave(1)
    assert topics.latched("chatter") is None


def test_latched_bytes_are_limited_and_freed() -> None:
    topics = ClientTopics()
    half = b"{" + bytes(MAX_LATCHED_BYTES // 2 - 1)
    for number in range(3):
        topics.advertise(f"t{number}", STRING, (number, None), latch=True)
    topics.take("t0", half, latch=True)
    topics.take("t1", half, latch=True)
    topics.take("t1", half, latch=True)
    with pytest.raises(QuotaExceeded):
        topics.take("t2", half, latch=True)
    topics.leave(0)
    topics.take("t2", half, latch=True)
    topics.drop("t1")
    topics.drop("t1")
    topics.advertise("t0", STRING, (0, None), latch=True)
    topics.take("t0", half, latch=True)


def test_number_of_topics_is_limited() -> None:
    topics = ClientTopics()
    topics.advertise(PRESENCE, "std_msgs/Bool", (0, None), latch=True)  # that of the cloud does not count
    for number in range(MAX_TOPICS):
        topics.advertise(f"t{number}", STRING, (1, None), latch=False)
    topics.advertise("t0", STRING, (2, None), latch=False)
    with pytest.raises(QuotaExceeded):
        topics.advertise("more", STRING, (1, None), latch=False)


@pytest.mark.parametrize("message", [b"1", b"[]", b"null", b'"x"'])
def test_message_must_be_an_object(message: bytes) -> None:
    topics = ClientTopics()
    topics.advertise("chatter", STRING, (1, None), latch=True)
    with pytest.raises(MalformedMessage):
        topics.take("chatter", message, latch=False)


def test_messages_of_types_that_the_cloud_knows_are_completed_or_refused() -> None:
    topics = ClientTopics()
    topics.advertise("joystick", "geometry_msgs/Twist", (1, None), latch=True)
    whole = topics.take("joystick", b'{"linear": {"x": 0.5}}', latch=False)
    zero = {"x": 0.0, "y": 0.0, "z": 0.0}
    assert json.loads(whole) == {"linear": zero | {"x": 0.5}, "angular": zero}
    assert topics.latched("joystick") == whole
    with pytest.raises(MalformedMessage, match=r"\$\.linear"):
        topics.take("joystick", b'{"linear": "fast"}', latch=False)
    assert topics.latched("joystick") == whole
