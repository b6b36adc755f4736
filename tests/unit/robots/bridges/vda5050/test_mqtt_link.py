"""Link to a broker, with a client in memory."""

import asyncio
from collections.abc import AsyncIterator
from typing import Any, ClassVar, Self

import pytest
from aiomqtt import MqttError
from aiomqtt.exceptions import MqttConnectError

from ppaas.errors import NotAuthenticated
from robots.bridges.vda5050 import mqtt_link
from robots.bridges.vda5050.broker import Broker
from robots.bridges.vda5050.mqtt_link import Exchange, MqttLink, Outgoing
from tests.support.waiting import patience


class Messages:
    """Messages of a client: none until the test breaks the connection."""

    def __init__(self) -> None:
        self.broken = asyncio.Event()

    async def __aiter__(self) -> AsyncIterator[Any]:
        await self.broken.wait()
        raise MqttError("disconnected")
        yield


class FakeClient:
    """Client of a broker in memory."""

    made: ClassVar["list[FakeClient]"] = []
    refusal: MqttError | None = None
    swallows = False

    def __init__(self, host: str, port: int, **options: Any) -> None:
        self.options, self.published, self.topics = options, list[Outgoing](), list[str]()
        self.messages = Messages()
        self.made.append(self)

    async def __aenter__(self) -> Self:
        if self.refusal is not None:
            raise self.refusal
        return self

    async def __aexit__(self, *_: object) -> None:
        if self.swallows:
            raise MqttError("no answer to the farewell")

    async def subscribe(self, topic: str, qos: int) -> None:
        self.topics.append(topic)

    async def publish(self, topic: str, payload: bytes, qos: int, retain: bool) -> None:
        try:
            await asyncio.sleep(0.001)
        except asyncio.CancelledError:
            if not self.swallows:
                raise
        self.published.append(Outgoing(topic, payload, qos, retain))


@pytest.fixture(autouse=True)
def client(monkeypatch: pytest.MonkeyPatch) -> type[FakeClient]:
    class Fresh(FakeClient):
        made: ClassVar[list[FakeClient]] = []

    monkeypatch.setattr(mqtt_link, "Client", Fresh)
    monkeypatch.setattr(mqtt_link, "backoff", lambda: iter([0.0] * 1000))
    return Fresh


def link_of(**uses: Any) -> MqttLink:
    exchange = Exchange(topics=("order",), received=lambda *_: None, **uses)
    return MqttLink(Broker("broker", 1883), "ppaas-1", exchange)


async def ended(task: "asyncio.Task[None]") -> None:
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await asyncio.wait_for(task, 5.0)


async def connected(link: MqttLink, times: int = 1) -> None:
    async with patience(5.0):
        while link.connections < times:
            await asyncio.sleep(0.001)


async def test_a_lost_connection_is_made_again_with_a_new_will(client: type[FakeClient]) -> None:
    wills = iter([Outgoing("connection", b"1", 1, True), Outgoing("connection", b"2", 1, True)])
    lost = list[int]()
    link = link_of(will=lambda: next(wills), lost=lambda: lost.append(1))
    running = asyncio.create_task(link.run())
    await connected(link)
    client.made[0].messages.broken.set()
    await connected(link, 2)
    assert [one.options["will"].payload for one in client.made] == [b"1", b"2"]
    assert [one.topics for one in client.made] == [["order"], ["order"]] and lost == [1]
    await ended(running)


async def test_a_link_that_ends_says_farewell(client: type[FakeClient]) -> None:
    link = link_of(farewell=lambda: Outgoing("connection", b"bye", 1, True))
    running = asyncio.create_task(link.run())
    await connected(link)
    await ended(running)
    assert client.made[0].published == [Outgoing("connection", b"bye", 1, True)]


async def test_a_refused_login_ends_the_first_connection(client: type[FakeClient]) -> None:
    client.refusal = MqttConnectError(5)
    with pytest.raises(NotAuthenticated, match="broker:1883"):
        await asyncio.wait_for(link_of().run(), 5.0)


async def test_a_broker_that_is_away_is_tried_again(client: type[FakeClient]) -> None:
    client.refusal = MqttError("connection refused")
    link = link_of()
    running = asyncio.create_task(link.run())
    async with patience(5.0):
        while len(client.made) < 3:
            await asyncio.sleep(0.001)
    client.refusal = None
    await connected(link)
    await ended(running)


async def test_a_cancellation_that_the_client_loses_ends_the_link(client: type[FakeClient]) -> None:
    client.swallows = True
    link = link_of(farewell=lambda: Outgoing("connection", b"bye"))
    running = asyncio.create_task(link.run())
    await connected(link)
    for number in range(50):
        link.outbox.put(Outgoing("state", str(number).encode()))
    await asyncio.sleep(0.005)
    await ended(running)
