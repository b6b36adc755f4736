"""Messages that a session sends by a timer: delayed by ``throttle_rate``, and the heartbeat.

The kind: silence that may mean two things. Its members are subscriptions to topics that are silent, or that do not
exist yet, while the connection may be lost.
"""

import asyncio
import json
from collections.abc import Iterator

import pytest

from engine.protocols import robot_link
from engine.sessions import session
from engine.sessions.session import DelayedMessages
from ppaas.wire.own_topics import HEARTBEAT
from ppaas.wire.rosbridge import RosbridgeSession
from tests.support.endpoints.still_place import StillClient, StillPlace, answers, error_of, says
from tests.support.waiting import until


class Delays:
    """A client with one throttled subscription, at a time that the test sets."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, rate: float = 1000) -> None:
        self.now = 100.0
        monkeypatch.setattr(session, "monotonic", lambda: self.now)
        self.wire = RosbridgeSession()
        self.wire.receive(json.dumps({"op": "subscribe", "topic": "a", "throttle_rate": rate, "queue_length": 9}))
        self.sent: list[bytes] = []
        self.messages = DelayedMessages(self.wire, lambda _topic, frame: self.sent.append(frame), lambda work: work())

    def publish(self, number: int) -> None:
        """Publish a message, which is sent or waits."""
        self.sent.extend(self.wire.publish("a", b"%d" % number, self.now))
        self.messages.schedule()

    @property
    def numbers(self) -> list[int]:
        """Messages that were sent."""
        return [json.loads(frame)["msg"] for frame in self.sent]


@pytest.mark.parametrize("ahead", [0.0, 1e-6, 4e-4, 6e-4, 2e-3])
async def test_messages_that_come_however_shortly_before_a_delayed_one_is_due_are_sent_in_order(
    monkeypatch: pytest.MonkeyPatch, ahead: float
) -> None:
    delays = Delays(monkeypatch)
    delays.publish(0)
    delays.now += 1.0 - ahead
    for number in (1, 2, 3):  # in one turn of the loop, before the timer runs
        delays.publish(number)
    delays.now += ahead
    await until(lambda: len(delays.sent) >= 2)
    assert delays.numbers == [0, 1]
    for count in (3, 4):
        delays.now += 1.0
        delays.messages.stop()
        delays.messages.schedule()
        await until(lambda count=count: len(delays.sent) >= count)  # type: ignore[misc]
    assert delays.numbers == [0, 1, 2, 3]


async def test_an_earlier_message_is_not_sent_later_because_of_another(monkeypatch: pytest.MonkeyPatch) -> None:
    delays = Delays(monkeypatch, 60_000)
    delays.wire.receive('{"op": "subscribe", "topic": "b", "throttle_rate": 1}')
    delays.publish(0)
    delays.publish(1)  # waits for a minute
    for _ in range(2):
        delays.sent.extend(delays.wire.publish("b", b"7", delays.now))
    delays.messages.schedule()
    delays.now += 0.001
    await until(lambda: len(delays.sent) == 3)
    assert delays.numbers == [0, 7, 7]
    delays.messages.stop()


async def test_no_message_is_sent_once_it_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    delays = Delays(monkeypatch, 1)
    delays.publish(0)
    delays.publish(1)
    delays.messages.stop()
    delays.now += 1.0
    for _ in range(5):
        await asyncio.sleep(0.002)
    assert delays.numbers == [0]


async def test_clients_that_throttle_take_nothing_from_clients_that_do_not(place: StillPlace) -> None:
    """The rates are those of eight clients with which others lost messages, and the publisher its connection."""
    robot, plain = StillClient(place, level="info"), StillClient(place, "operator")
    robot.say(op="advertise", topic="count", type="std_msgs/Int32")
    throttled = [StillClient(place, "operator") for _ in range(8)]
    for client, rate in zip(throttled, (1, 2, 3, 5, 7, 11, 19, 29), strict=True):
        client.say(op="subscribe", topic="count", throttle_rate=rate)
    plain.say(op="subscribe", topic="count", queue_length=1000)
    for number in range(200):
        robot.say(op="publish", topic="count", msg={"data": number})
        if number % 4 == 0:
            await asyncio.sleep(0.0005 * (number % 3))
    assert [frame["msg"]["data"] for frame in plain.received()] == list(range(200))
    assert robot.received() == []
    for client in throttled:
        heard: list[int] = []

        def last_came(client: StillClient = client, heard: list[int] = heard) -> bool:
            heard.extend(frame["msg"]["data"] for frame in client.received())
            return heard[-1:] == [199]

        await until(last_came)
        assert heard == sorted(set(heard)) and not client.session.over.done()


@pytest.fixture(autouse=True)
def fast(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(session, "HEARTBEAT_PERIOD", 0.01)
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
    assert place.far.take(robot_link.SubscribeTopic) == []


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
