"""Messages that ``throttle_rate`` delays, on the loop that containers run on and on that of asyncio."""

import asyncio
import json

import pytest

from engine.sessions import delayed_messages
from engine.sessions.delayed_messages import DelayedMessages
from ppaas.wire.rosbridge import RosbridgeSession
from tests.support.endpoints.still_place import StillClient, StillPlace
from tests.support.waiting import until


class Delays:
    """A client with one throttled subscription, at a time that the test sets."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, rate: float = 1000) -> None:
        self.now = 100.0
        monkeypatch.setattr(delayed_messages, "monotonic", lambda: self.now)
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
