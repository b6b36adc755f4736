"""Messages that wait for the broker."""

import asyncio

import pytest

from ppaas.errors import Unavailable
from robots.bridges.vda5050.mqtt_link import Outbox, Outgoing


def of(topic: str, payload: bytes = b"") -> Outgoing:
    return Outgoing(topic, payload)


async def taken(outbox: Outbox) -> list[tuple[str, bytes]]:
    return [((one := await outbox.next()).topic, one.payload) for _ in range(len(outbox))]


async def test_messages_leave_in_order() -> None:
    outbox = Outbox()
    for payload in (b"1", b"2"):
        outbox.put(of("order", payload))
    outbox.put_newest(of("state", b"3"))
    assert await taken(outbox) == [("order", b"1"), ("order", b"2"), ("state", b"3")]


async def test_the_newest_message_of_a_topic_replaces_the_others() -> None:
    outbox = Outbox()
    for payload in (b"1", b"2"):
        outbox.put_newest(of("state", payload))
        outbox.put_newest(of("visualization", payload))
    assert await taken(outbox) == [("state", b"2"), ("visualization", b"2")]
    assert outbox.dropped == 2


async def test_a_full_outbox_says_so() -> None:
    outbox = Outbox(capacity=2)
    outbox.put(of("order"))
    outbox.put(of("order"))
    with pytest.raises(Unavailable, match="broker"):
        outbox.put(of("order"))
    outbox.put_newest(of("state"))
    assert (len(outbox), outbox.dropped) == (2, 1)


async def test_a_message_that_was_not_sent_comes_first_again() -> None:
    outbox = Outbox()
    outbox.put(of("order", b"1"))
    outbox.put(of("order", b"2"))
    outbox.put_back(await outbox.next())
    assert await taken(outbox) == [("order", b"1"), ("order", b"2")]


async def test_an_older_message_does_not_come_back_beside_a_newer() -> None:
    outbox = Outbox()
    outbox.put_newest(of("state", b"1"))
    old = await outbox.next()
    outbox.put_newest(of("state", b"2"))
    outbox.put_back(old)
    assert await taken(outbox) == [("state", b"2")]


async def test_the_sender_waits_for_a_message() -> None:
    outbox = Outbox()
    waiting = asyncio.create_task(outbox.next())
    await asyncio.sleep(0)
    assert not waiting.done()
    outbox.put(of("order"))
    assert (await waiting).topic == "order"
