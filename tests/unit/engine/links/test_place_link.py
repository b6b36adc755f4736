"""Place links, with containers that connect and disconnect at a real socket; which frames of clients may be lost."""

import asyncio
from collections.abc import AsyncIterator

import cbor2
import pytest

from engine.links.carried_session import is_stream
from engine.links.place_link import PlaceLink
from engine.links.shared_place import MAX_UNACKNOWLEDGED, MAX_UNACKNOWLEDGED_BYTES
from engine.protocols import robot_link
from engine.protocols.refusals import Refusal
from engine.protocols.session_frames import NumberedFrame
from ppaas.errors import PPaaSError, QuotaExceeded, Unavailable
from tests.support.engine.place_peers import NODES, SERVICES, TOPICS, FakeContainer, RecordingClient, close_links
from tests.support.waiting import patience


class FaultyClient(RecordingClient):
    """Client of a place all of whose methods fail."""

    def published(self, topic: str, payload: bytes) -> None:
        raise RuntimeError("published")

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        raise RuntimeError("refused")

    def acknowledged(self, sequence: int) -> None:
        raise RuntimeError("acknowledged")

    def closed(self, reason: PPaaSError) -> None:
        raise RuntimeError("closed")


@pytest.fixture(autouse=True)
async def links() -> AsyncIterator[None]:
    """Close the links that a test left open."""
    yield
    await close_links()


async def test_place_is_ready_after_the_hello_of_a_container() -> None:
    place = PlaceLink("robot:a/r")
    with pytest.raises(Unavailable):
        await place.ready(0.01)
    container = await FakeContainer.ready(place, "c1")
    assert (place.container, place.pid) == ("c1", 42)
    await container.die()
    assert place.container is None


async def test_offers_of_the_container_are_known_also_those_of_run_time() -> None:
    place = PlaceLink("robot:a/r")
    container = await FakeContainer.ready(place, "c1")
    assert (list(place.topics.values()), list(place.services.values())) == (TOPICS, SERVICES)
    client = RecordingClient()
    number = place.join(client)
    fleeting = robot_link.TopicInfo("fleeting", "std_msgs/String", False)
    container.stream.write(robot_link.TopicAdded(fleeting, "planner"))
    container.stream.write(robot_link.MessageRefused(number, "x", Refusal("invalid-input", "so far")))
    await client.notified()
    assert place.topics["fleeting"] == fleeting
    assert place.nodes["planner"].publishes == ("map", "fleeting")
    container.stream.write(robot_link.TopicRemoved("fleeting"))
    container.stream.write(robot_link.MessageRefused(number, "x", Refusal("invalid-input", "so far")))
    await client.notified()
    assert "fleeting" not in place.topics
    assert list(place.nodes.values()) == NODES
    await container.die()


async def test_subscriptions_are_repeated_for_the_next_container() -> None:
    place = PlaceLink("robot:a/r")
    listener = RecordingClient()
    client = place.join(listener)
    first = await FakeContainer.ready(place, "c1")
    place.subscribe("map", client)
    assert await first.next() == robot_link.SubscribeTopic("map", client)
    await first.die()
    second = await FakeContainer.dial(place, "c2")
    assert await second.next() == robot_link.SubscribeTopic("map", 0)
    second.stream.write(robot_link.Published("map", b"{}"))
    await listener.notified()
    assert listener.heard == [("map", b"{}")]
    await second.die()


async def test_latched_message_for_one_client_does_not_reach_others() -> None:
    place = PlaceLink("robot:a/r")
    listeners = [RecordingClient(), RecordingClient()]
    numbers = [place.join(listener) for listener in listeners]
    container = await FakeContainer.ready(place, "c1")
    for number in numbers:
        place.subscribe("map", number)
    container.stream.write(robot_link.Published("map", b"{}", numbers[1]))
    await listeners[1].notified()
    assert listeners[0].heard == []
    await container.die()


async def test_only_clients_without_the_changes_of_a_map_get_the_whole_map_again() -> None:
    place = PlaceLink("robot:a/r")
    container = await FakeContainer.ready(place, "c1")
    both, whole = (place.join(RecordingClient()) for _ in range(2))
    for topic, client in (("map", both), ("map_updates", both), ("map", whole)):
        place.subscribe(topic, client)
        assert await container.next() == robot_link.SubscribeTopic(topic, client)
    container.stream.write(robot_link.MapReplaced())
    assert await container.next() == robot_link.SubscribeTopic("map", whole)
    await container.die()


async def test_subscription_ends_with_its_last_client() -> None:
    place = PlaceLink("robot:a/r")
    one, two = place.join(RecordingClient()), place.join(RecordingClient())
    container = await FakeContainer.ready(place, "c1")
    place.subscribe("map", one)
    place.subscribe("map", two)
    place.leave(one)
    place.leave(two)
    frames = [await container.next() for _ in range(3)]
    assert frames == [
        robot_link.SubscribeTopic("map", one),
        robot_link.SubscribeTopic("map", two),
        robot_link.UnsubscribeTopic("map"),
    ]
    await container.die()


async def test_call_is_answered_or_fails_with_its_container() -> None:
    place = PlaceLink("robot:a/r")
    with pytest.raises(Unavailable):
        await place.call("make_plan", b"{}", 1.0)
    container = await FakeContainer.ready(place, "c1")
    answered = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    refused = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    lost = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    calls = [await container.next() for _ in range(3)]
    numbers = [call.call for call in calls if isinstance(call, robot_link.ServiceCall)]
    container.stream.write(robot_link.ServiceAnswer(numbers[0], b'{"plan":1}'))
    container.stream.write(robot_link.ServiceAnswer(numbers[1], refusal=Refusal("no-valid-path", "none")))
    assert await answered == b'{"plan":1}'
    with pytest.raises(PPaaSError) as error:
        await refused
    assert error.value.slug == "no-valid-path"
    await container.die()
    with pytest.raises(Unavailable, match="lost"):
        await lost


async def test_ended_subscription_is_not_repeated_for_the_next_container() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(RecordingClient())
    first = await FakeContainer.ready(place, "c1")
    place.subscribe("map", client)
    place.unsubscribe("map", client)
    first.stream.write(robot_link.Published("map", b"{}"))  # sent before the unsubscription arrived
    first.stream.write(robot_link.Published("goal", b"{}"))
    await first.die()
    place.subscribe("goal", client)
    second = await FakeContainer.ready(place, "c2")
    place.unsubscribe("goal", client)
    assert [await second.next(), await second.next()] == [
        robot_link.SubscribeTopic("goal", 0),
        robot_link.UnsubscribeTopic("goal"),
    ]
    await second.die()


async def test_frames_of_a_replaced_container_are_ignored() -> None:
    place = PlaceLink("robot:a/r")
    listener = RecordingClient()
    client = place.join(listener)
    first = await FakeContainer.ready(place, "c1")
    place.subscribe("goal", client)
    place.deliver("goal", b"1", client, must_arrive=True)
    call = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    assert [type(await first.next()) for _ in range(3)] == [
        robot_link.SubscribeTopic,
        robot_link.Deliver,
        robot_link.ServiceCall,
    ]
    second = await FakeContainer.dial(place, "c2")
    assert [type(await second.next()) for _ in range(2)] == [robot_link.SubscribeTopic, robot_link.Deliver]
    with pytest.raises(Unavailable, match="lost"):
        await call
    first.stream.write(robot_link.Ack(1))
    first.stream.write(robot_link.Published("goal", b"old"))
    async with patience(5):
        await first.serving  # its frames are ignored, and its link is closed
    second.stream.write(robot_link.Published("goal", b"new"))
    await listener.notified()
    assert listener.heard == [("goal", b"new")]
    assert place.container == "c2"
    await second.die()
    third = await FakeContainer.dial(place, "c3")
    assert [type(await third.next()) for _ in range(2)] == [robot_link.SubscribeTopic, robot_link.Deliver]
    await third.die()


async def test_closed_place_states_the_reason_after_its_container_exited() -> None:
    place = PlaceLink("robot:a/r")
    container = await FakeContainer.ready(place, "c1")
    place.close(Unavailable("over"))
    assert await container.next() == robot_link.Shutdown()
    await container.die()
    with pytest.raises(Unavailable, match="over"):
        await place.ready(5)


async def test_client_that_joins_a_closed_place_gets_the_reason_at_once() -> None:
    place = PlaceLink("robot:a/r")
    place.close(Unavailable("over"))
    late = RecordingClient()
    place.leave(place.join(late))
    assert [str(reason) for reason in late.reasons] == ["over"]


async def test_closing_reports_the_reason_to_every_client() -> None:
    place = PlaceLink("robot:a/r")
    listener = RecordingClient()
    place.join(listener)
    place.close(Unavailable("over"))
    assert [str(reason) for reason in listener.reasons] == ["over"]
    with pytest.raises(Unavailable, match="over"):
        await place.ready(1)


async def test_acknowledgements_and_the_end_reach_all_whatever_one_does() -> None:
    place = PlaceLink("robot:a/r")
    clients = [FaultyClient(), RecordingClient()]
    for client in clients:
        place.join(client)
    place.take(robot_link.Ack(7))
    place.close(Unavailable("over"))
    assert clients[1].acknowledgements == [7]
    assert [str(reason) for reason in clients[1].reasons] == ["over"]
    assert place.clients == 0


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


SCAN = {"op": "publish", "topic": "/scan", "msg": {"ranges": [1.0]}}


@pytest.mark.parametrize(
    ("content", "binary"),
    [
        (b'{"op": "publish", "topic": "/scan", "msg": {}}', False),
        (b'{"msg": {"text": "T\xc3\xbcr"}, "topic": "tb1/odom", "op": "publish"}', False),
        (b'{"op": "publish", "topic": "scan", "msg": {}}', True),
        (cbor2.dumps(SCAN), True),
    ],
)
def test_a_scan_in_any_form_is_of_a_stream(content: bytes, binary: bool) -> None:
    assert is_stream(NumberedFrame(1, content, binary))


@pytest.mark.parametrize(
    ("content", "binary"),
    [
        (b'{"op": "subscribe", "topic": "/scan"}', False),
        (b'{"op": "publish", "topic": "goal", "msg": {}}', False),
        (cbor2.dumps(SCAN), False),
        (cbor2.dumps(SCAN | {"topic": "goal"}), True),
        (b'{"op": "publish", "topic": "\xff"}', False),
        (b"\xff", True),
        (b"[]", False),
    ],
)
def test_any_other_frame_must_arrive(content: bytes, binary: bool) -> None:
    assert not is_stream(NumberedFrame(1, content, binary))
