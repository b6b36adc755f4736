"""Messages over a place link that must arrive, also if the container is replaced."""

from collections.abc import AsyncIterator

import pytest

from engine.links.shared_place import MAX_UNACKNOWLEDGED, MAX_UNACKNOWLEDGED_BYTES
from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from engine.service.links.place_link import PlaceLink
from ppaas.errors import QuotaExceeded
from tests.support.engine.place_peers import FakeContainer, RecordingClient, close_links


@pytest.fixture(autouse=True)
async def links() -> AsyncIterator[None]:
    """Close the links that a test left open."""
    yield
    await close_links()


async def test_goal_sent_without_a_container_reaches_the_next() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(RecordingClient())
    place.deliver("goal", b'"1"', client, must_arrive=True)
    place.deliver("scan", b"{}", client, must_arrive=False)
    container = await FakeContainer.dial(place, "c1")
    assert await container.next() == robot_link.Deliver("goal", b'"1"', client, 1)
    await container.die()


async def test_unacknowledged_messages_are_resent_in_order() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(RecordingClient())
    first = await FakeContainer.ready(place, "c1")
    for number in (b"1", b"2", b"3"):
        place.deliver("goal", number, client, must_arrive=True)
    for _ in range(3):
        await first.next()
    first.stream.write(robot_link.Ack(1))
    await first.die()
    second = await FakeContainer.dial(place, "c2", applied=1)
    resent = [await second.next(), await second.next()]
    assert [(d.payload, d.sequence) for d in resent if isinstance(d, robot_link.Deliver)] == [(b"2", 2), (b"3", 3)]
    await second.die()


async def test_message_in_the_checkpoint_is_not_resent() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(RecordingClient())
    await (await FakeContainer.dial(place, "c1")).die()
    place.deliver("goal", b"1", client, must_arrive=True)
    place.deliver("goal", b"2", client, must_arrive=True)
    container = await FakeContainer.dial(place, "c2", applied=1)
    resent = await container.next()
    assert isinstance(resent, robot_link.Deliver) and resent.payload == b"2"
    await container.die()


async def test_numbers_continue_those_of_an_earlier_cloud_process() -> None:
    listening, place = RecordingClient(), PlaceLink("robot:a/r")
    client = place.join(listening)
    before = place.deliver("goal", b"1", client, must_arrive=True)
    container = await FakeContainer.dial(place, "c1", applied=57)
    after = place.deliver("goal", b"2", client, must_arrive=True)
    assert [await container.next(), await container.next()] == [
        robot_link.Deliver("goal", b"1", client, 58),
        robot_link.Deliver("goal", b"2", client, 59),
    ]
    assert (before, after) == (1, 2)
    container.stream.write(robot_link.MessageRefused(client, "goal", Refusal("invalid-input", "no goal"), 59))
    container.stream.write(robot_link.Ack(58))
    await listening.news.wait()
    assert listening.refused_numbers == [after]
    await container.die()
    second = await FakeContainer.dial(place, "c2", applied=58)
    assert await second.next() == robot_link.Deliver("goal", b"2", client, 59)
    await second.die()


async def test_number_of_unacknowledged_messages_is_bounded() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(RecordingClient())
    for _ in range(MAX_UNACKNOWLEDGED):
        place.deliver("goal", b"1", client, must_arrive=True)
    with pytest.raises(QuotaExceeded):
        place.deliver("goal", b"1", client, must_arrive=True)


async def test_bytes_of_unacknowledged_messages_are_bounded_until_acknowledged() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(RecordingClient())
    await (await FakeContainer.dial(place, "c0")).die()
    half = bytes(MAX_UNACKNOWLEDGED_BYTES // 2)
    place.deliver("cloud", half, client, must_arrive=True)
    place.deliver("cloud", half, client, must_arrive=True)
    with pytest.raises(QuotaExceeded):
        place.deliver("cloud", b"1", client, must_arrive=True)
    container = await FakeContainer.dial(place, "c1", applied=1)
    resent = await container.next()
    assert isinstance(resent, robot_link.Deliver) and resent.sequence == 2
    place.deliver("cloud", b"1", client, must_arrive=True)
    await container.die()
