"""A heartbeat tells a client that its connection is alive, whatever is published.

The kind: silence that may mean two things. Its members are subscriptions to topics that are silent, or that do not
exist yet, while the connection may be lost.
"""

from collections.abc import Iterator

import pytest

from engine.protocols import robot_link
from engine.sessions import heartbeat
from ppaas.wire.own_topics import HEARTBEAT
from tests.support.endpoints.still_place import StillClient, StillPlace, answers, error_of, says


@pytest.fixture(autouse=True)
def fast(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(heartbeat, "PERIOD", 0.01)
    yield


async def test_a_client_that_subscribes_hears_the_heartbeat_at_once_and_again(
    client: StillClient, other: StillClient, place: StillPlace
) -> None:
    [first] = says(client, op="subscribe", topic="/ppaas/heartbeat", type="std_msgs/msg/Header")
    assert (first["op"], first["topic"]) == ("publish", "/ppaas/heartbeat")
    assert set(first["msg"]["stamp"]) == {"sec", "nanosec"}
    later = await answers(client, 2)
    assert later[0]["msg"]["stamp"] != first["msg"]["stamp"]
    assert other.received() == []
    assert place.far.take(robot_link.Subscribe) == []


async def test_it_ends_with_the_last_subscription(client: StillClient) -> None:
    for identity in ("a", "b"):
        client.say(op="subscribe", topic=HEARTBEAT, id=identity)
    client.say(op="unsubscribe", topic=HEARTBEAT, id="a")
    assert await answers(client, 3)
    client.say(op="unsubscribe", topic=HEARTBEAT, id="b")
    client.received()
    assert client.session._heartbeat._timer is None
    client.say(op="subscribe", topic=HEARTBEAT)
    assert await answers(client, 2)


async def test_it_ends_with_the_session(place: StillPlace) -> None:
    client = StillClient(place)
    client.say(op="subscribe", topic=HEARTBEAT)
    client.session.end()
    assert client.session._heartbeat._timer is None


async def test_it_may_be_throttled(client: StillClient) -> None:
    client.say(op="subscribe", topic=HEARTBEAT, throttle_rate=60_000)
    assert len(client.received()) == 1


async def test_it_has_one_type(client: StillClient) -> None:
    error_of(says(client, op="subscribe", topic=HEARTBEAT, type="std_msgs/String"), "conflict")
    assert client.session._heartbeat._timer is None


async def test_no_client_publishes_it(client: StillClient) -> None:
    error_of(says(client, op="publish", topic=HEARTBEAT, msg={}), "not-permitted")
    error_of(says(client, op="advertise", topic=HEARTBEAT, type="std_msgs/Header"), "not-permitted")


async def test_rosapi_lists_it(client: StillClient) -> None:
    [answer] = says(client, op="call_service", service="/rosapi/topic_type", args={"topic": "/ppaas/heartbeat"})
    assert answer["values"] == {"type": "std_msgs/Header"}
    [answer] = says(client, op="call_service", service="/rosapi/publishers", args={"topic": "/ppaas/heartbeat"})
    assert answer["values"] == {"publishers": ["/rosapi"]}
