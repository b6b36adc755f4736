"""A place at a real clone: what clients give it arrives at once, what it says in one order and in the next turn."""

import asyncio
from collections.abc import AsyncIterator
from typing import NoReturn

import pytest

from engine.links.shared_place import MAX_UNACKNOWLEDGED, MAX_UNACKNOWLEDGED_BYTES
from engine.protocols import robot_link
from engine.sessions.place.place import Place
from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable
from ppaas.messages import decode
from ppaas.messages.base.std_msgs import String
from ppaas.messages.std_srvs import TriggerResponse
from ppaas.nodes.base import Topic
from tests.support.endpoints.still_place import StillPlace
from tests.support.engine.container_peers import ContainerPeers
from tests.support.engine.place_peers import RecordingClient
from tests.support.engine.specs import robot_spec
from tests.support.waiting import until


@pytest.fixture
async def peers() -> AsyncIterator[ContainerPeers]:
    made = await ContainerPeers(robot_spec()).start()
    yield made
    await made.close()


@pytest.fixture
async def place(peers: ContainerPeers) -> Place:
    made = Place("robot:ann/tb1")
    made.begin(peers.container)
    return made


def message(word: str) -> bytes:
    return b'{"data":"%s"}' % word.encode()


async def test_a_place_knows_what_its_clone_has(place: Place, peers: ContainerPeers) -> None:
    assert {*place.topics} == {*peers.home.graph.topics} and "heard" in place.services and "echo" in place.nodes


async def test_a_message_is_taken_at_once_and_its_reaction_heard_in_the_next_turn(place: Place) -> None:
    listener = RecordingClient()
    client = place.join(listener)
    place.hear("echo", client)
    assert place.publish("say", message("hi"), client, must_arrive=False) == 0
    assert listener.heard == []
    await asyncio.sleep(0)
    assert listener.heard == [("echo", message("hi"))]


async def test_news_keep_their_order(place: Place, peers: ContainerPeers) -> None:
    listener = RecordingClient()
    client, topic = place.join(listener), Topic("fleeting", String)
    for name in ("echo", "fleeting"):
        place.hear(name, client)
    place.publish("say", message("first"), client, must_arrive=True)
    place.publish("say", message("refuse"), client, must_arrive=True)
    peers.home.graph.declare(peers.node, topic)
    peers.home.graph.publish("fleeting", String("once"))
    peers.home.graph.undeclare(peers.node, "fleeting")
    place.publish("say", message("last"), client, must_arrive=True)
    assert (listener.heard, listener.refused_numbers, "fleeting" in place.topics) == ([], [], False)
    await asyncio.sleep(0)
    assert listener.heard == [("echo", message("first")), ("fleeting", message("once")), ("echo", message("last"))]
    assert listener.refused_numbers == [2] and [error.slug for error in listener.errors] == ["invalid-input"]
    assert "fleeting" not in place.topics and "fleeting" not in place.nodes["echo"].publishes


async def test_a_latched_message_is_sent_to_the_new_subscriber_only(place: Place, peers: ContainerPeers) -> None:
    one, two = RecordingClient(), RecordingClient()
    place.hear("last", place.join(one))
    peers.home.graph.publish("last", String("old"))
    await asyncio.sleep(0)
    place.hear("last", place.join(two))
    await asyncio.sleep(0)
    assert one.heard == two.heard == [("last", message("old"))]


async def test_an_ended_subscription_hears_nothing(place: Place, peers: ContainerPeers) -> None:
    listener = RecordingClient()
    client = place.join(listener)
    place.hear("echo", client)
    place.publish("say", message("late"), client, must_arrive=False)
    place.leave(client)
    assert not peers.home.graph.has_taps("echo")
    await asyncio.sleep(0)
    assert listener.heard == []


async def test_calls_are_answered_also_those_that_fail(place: Place) -> None:
    place.publish("say", message("hi"), 1, must_arrive=False)
    assert decode(TriggerResponse, await place.call("heard", b"{}", 5.0)).message == "hi"
    for service, slug in (("refuse", "invalid-input"), ("break", "error"), ("nowhere", "not-found")):
        with pytest.raises(PPaaSError) as failed:
            await place.call(service, b"{}", 5.0)
        assert failed.value.slug == slug


async def test_messages_are_acknowledged_once_a_checkpoint_has_them(place: Place, peers: ContainerPeers) -> None:
    listener = RecordingClient()
    client = place.join(listener)
    keeping = asyncio.create_task(peers.container.keep_checkpoints())
    assert [place.publish("say", message("a"), client, must_arrive=True) for _ in range(2)] == [1, 2]
    while (await peers.checkpoint())["echo"] != b"a,a":
        assert not {1, 2} & {*listener.acknowledgements}
    await until(lambda: 2 in listener.acknowledgements)
    keeping.cancel()


async def test_unacknowledged_messages_are_bounded_in_number_and_bytes() -> None:
    place = StillPlace()
    for _ in range(MAX_UNACKNOWLEDGED):
        place.publish("goal", b"1", 1, must_arrive=True)
    with pytest.raises(QuotaExceeded):
        place.publish("goal", b"1", 1, must_arrive=True)
    place.say(robot_link.Ack(MAX_UNACKNOWLEDGED))
    half = bytes(MAX_UNACKNOWLEDGED_BYTES // 2)
    for _ in range(2):
        place.publish("goal", half, 1, must_arrive=True)
    with pytest.raises(QuotaExceeded):
        place.publish("goal", b"1", 1, must_arrive=True)
    place.say(robot_link.Ack(MAX_UNACKNOWLEDGED + 1))
    assert place.publish("goal", b"1", 1, must_arrive=True) == MAX_UNACKNOWLEDGED + 3


async def test_news_that_cannot_be_passed_on_keep_no_other_back(
    place: Place, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fail() -> NoReturn:
        raise RuntimeError("a fault of the place")

    monkeypatch.setattr(place, "_map_replaced", fail)
    listener = RecordingClient()
    place.hear("echo", place.join(listener))
    place.map_replaced()
    place.published("echo", message("hi"))
    await until(lambda: bool(listener.heard))
    assert "a fault of the place" in caplog.text


async def test_a_place_without_a_clone_takes_neither_messages_nor_calls() -> None:
    place = Place("robot:ann/tb1")
    with pytest.raises(Unavailable):
        place.publish("say", b"{}", 1, must_arrive=True)
    with pytest.raises(Unavailable):
        place.begin_call("heard", b"{}", 1.0, lambda _: None)
    with pytest.raises(Unavailable):
        await place.call("heard", b"{}", 1.0)
