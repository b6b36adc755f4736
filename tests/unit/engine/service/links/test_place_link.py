"""Tests of place links, with containers that connect and disconnect at the other end of a real socket."""

import asyncio
import socket

import pytest

from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.service.links.place_link import PlaceLink
from engine.service.links.unacknowledged import MAX_UNACKNOWLEDGED, MAX_UNACKNOWLEDGED_BYTES
from ppaas.errors import Conflict, NotFound, NotPermitted, PPaaSError, QuotaExceeded, Unavailable
from tests.support.waiting import until

TOPICS = [
    robot_link.TopicInfo("map", "nav_msgs/OccupancyGrid", True),
    robot_link.TopicInfo("goal", "std_msgs/String", False),
]
SERVICES = [robot_link.ServiceInfo("make_plan", "nav_msgs/GetPlan")]
NODES = [robot_link.NodeInfo("planner", ("map",), ("goal",), ("make_plan",))]


class Client:
    """Records the calls that it gets."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, bytes]] = []
        self.errors: list[PPaaSError] = []
        self.refused_numbers: list[int] = []
        self.calls: list[tuple[int, str, bytes]] = []
        self.reasons: list[PPaaSError] = []
        self.news = asyncio.Event()

    def published(self, topic: str, payload: bytes) -> None:
        self.heard.append((topic, payload))
        self.news.set()

    def refused(self, topic: str, error: PPaaSError, sequence: int) -> None:
        self.errors.append(error)
        self.refused_numbers.append(sequence)
        self.news.set()

    def requested(self, call: int, service: str, payload: bytes) -> None:
        self.calls.append((call, service, payload))
        self.news.set()

    def closed(self, reason: PPaaSError) -> None:
        self.reasons.append(reason)

    async def told(self) -> None:
        async with asyncio.timeout(5):
            await self.news.wait()
        self.news.clear()


OPENED: list[FrameStream] = []


@pytest.fixture(autouse=True)
async def hung_up():
    """Close what a test left open."""
    yield
    while OPENED:
        await OPENED.pop().close()


class FakeContainer:
    """The container's end of the link, driven frame by frame."""

    def __init__(self, stream: FrameStream[robot_link.ToContainer], serving: asyncio.Task[None]) -> None:
        self.stream = stream
        self.serving = serving

    @classmethod
    async def dial(cls, place: PlaceLink, name: str, applied: int = 0) -> "FakeContainer":
        ours, theirs = socket.socketpair()
        near: FrameStream[robot_link.FromContainer] = FrameStream(
            *await asyncio.open_connection(sock=ours), robot_link.FromContainer
        )
        far: FrameStream[robot_link.ToContainer] = FrameStream(
            *await asyncio.open_connection(sock=theirs), robot_link.ToContainer
        )
        OPENED.extend((near, far))
        hello = robot_link.Hello(name, "", 42, applied, TOPICS, SERVICES, NODES)
        return cls(far, asyncio.create_task(place.serve(hello, near)))

    async def next(self) -> robot_link.ToContainer | None:
        async with asyncio.timeout(5):
            return await self.stream.receive()

    async def die(self) -> None:
        await self.stream.close()
        await self.serving


async def test_ready_means_that_a_container_said_hello() -> None:
    place = PlaceLink("robot:a/r")
    with pytest.raises(Unavailable):
        await place.ready(0.01)
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    assert (place.container, place.pid) == ("c1", 42)
    await container.die()
    assert place.container is None


async def test_a_place_knows_what_its_container_offers_also_what_comes_and_goes_at_run_time() -> None:
    place = PlaceLink("robot:a/r")
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    assert (list(place.topics.values()), list(place.services.values())) == (TOPICS, SERVICES)
    client = Client()
    number = place.join(client)
    fleeting = robot_link.TopicInfo("fleeting", "std_msgs/String", False)
    container.stream.write(robot_link.TopicAdded(fleeting, "planner"))
    container.stream.write(robot_link.MessageRefused(number, "x", robot_link.Refusal("invalid-input", "so far")))
    await client.told()
    assert place.topics["fleeting"] == fleeting
    assert place.nodes["planner"].publishes == ("map", "fleeting")
    container.stream.write(robot_link.TopicRemoved("fleeting"))
    container.stream.write(robot_link.MessageRefused(number, "x", robot_link.Refusal("invalid-input", "so far")))
    await client.told()
    assert "fleeting" not in place.topics
    assert list(place.nodes.values()) == NODES
    await container.die()


async def test_a_goal_sent_while_no_container_is_there_reaches_the_next() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
    place.deliver("goal", b'"1"', client, must_arrive=True)
    place.deliver("scan", b"{}", client, must_arrive=False)
    container = await FakeContainer.dial(place, "c1")
    assert await container.next() == robot_link.Deliver("goal", b'"1"', client, 1)
    await container.die()


async def test_what_was_not_acknowledged_is_sent_again_in_order_and_what_was_is_not() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
    first = await FakeContainer.dial(place, "c1")
    await place.ready(5)
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


async def test_a_checkpoint_that_knows_a_message_counts_as_its_acknowledgement() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
    await (await FakeContainer.dial(place, "c1")).die()
    place.deliver("goal", b"1", client, must_arrive=True)
    place.deliver("goal", b"2", client, must_arrive=True)
    container = await FakeContainer.dial(place, "c2", applied=1)
    resent = await container.next()
    assert isinstance(resent, robot_link.Deliver) and resent.payload == b"2"
    await container.die()


async def test_the_numbers_of_a_container_that_another_cloud_process_has_served_go_on() -> None:
    listening, place = Client(), PlaceLink("robot:a/r")
    client = place.join(listening)
    before = place.deliver("goal", b"1", client, must_arrive=True)
    container = await FakeContainer.dial(place, "c1", applied=57)
    after = place.deliver("goal", b"2", client, must_arrive=True)
    assert [await container.next(), await container.next()] == [
        robot_link.Deliver("goal", b"1", client, 58),
        robot_link.Deliver("goal", b"2", client, 59),
    ]
    assert (before, after) == (1, 2)
    container.stream.write(
        robot_link.MessageRefused(client, "goal", robot_link.Refusal("invalid-input", "no goal"), 59)
    )
    container.stream.write(robot_link.Ack(58))
    await listening.news.wait()
    assert listening.refused_numbers == [after]
    await container.die()
    second = await FakeContainer.dial(place, "c2", applied=58)
    assert await second.next() == robot_link.Deliver("goal", b"2", client, 59)
    await second.die()


async def test_subscriptions_are_made_again_with_the_next_container() -> None:
    place = PlaceLink("robot:a/r")
    listener = Client()
    client = place.join(listener)
    first = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    place.subscribe("map", client)
    assert await first.next() == robot_link.Subscribe("map", client)
    await first.die()
    second = await FakeContainer.dial(place, "c2")
    assert await second.next() == robot_link.Subscribe("map", 0)
    second.stream.write(robot_link.Published("map", b"{}"))
    await listener.told()
    assert listener.heard == [("map", b"{}")]
    await second.die()


async def test_a_latched_message_for_one_client_is_not_heard_by_the_others() -> None:
    place = PlaceLink("robot:a/r")
    listeners = [Client(), Client()]
    numbers = [place.join(listener) for listener in listeners]
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    for number in numbers:
        place.subscribe("map", number)
    container.stream.write(robot_link.Published("map", b"{}", numbers[1]))
    await listeners[1].told()
    assert listeners[0].heard == []
    await container.die()


async def test_the_last_to_leave_ends_the_subscription() -> None:
    place = PlaceLink("robot:a/r")
    one, two = place.join(Client()), place.join(Client())
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    place.subscribe("map", one)
    place.subscribe("map", two)
    place.leave(one)
    place.leave(two)
    frames = [await container.next() for _ in range(3)]
    assert frames == [robot_link.Subscribe("map", one), robot_link.Subscribe("map", two), robot_link.Unsubscribe("map")]
    await container.die()


async def test_a_topic_that_is_not_there_yet_is_heard_once_somebody_advertises_it() -> None:
    place = PlaceLink("robot:a/r")
    listener = Client()
    hearer, speaker = place.join(listener), place.join(Client())
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    place.subscribe("chatter", hearer, "std_msgs/String")
    assert place.topic_type("chatter") is None
    with pytest.raises(NotFound, match="known: goal, map"):
        place.publish("chatter", b"{}", speaker, must_arrive=True)
    place.advertise("chatter", "std_msgs/String", speaker, "1", latch=False)
    place.publish("chatter", b'{"data":"hi"}', speaker, must_arrive=True)
    assert listener.heard == [("chatter", b'{"data":"hi"}')]
    place.leave(speaker)
    assert place.topic_type("chatter") is None
    await container.die()


async def test_a_topic_of_the_clone_keeps_its_type_and_its_way() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    with pytest.raises(Conflict, match="has type std_msgs/String"):
        place.advertise("goal", "std_msgs/Bool", client, None, latch=False)
    with pytest.raises(Conflict, match="has type nav_msgs/OccupancyGrid"):
        place.subscribe("map", client, "std_msgs/String")
    place.advertise("goal", "std_msgs/String", client, None, latch=False)
    place.unadvertise("goal", client, None)
    assert place.publish("goal", b"{}", client, must_arrive=True) == 1
    assert place.publish("goal", b"{}", client, must_arrive=False) == 0
    assert isinstance(await container.next(), robot_link.Deliver)
    await container.die()


async def test_a_name_that_the_clone_takes_is_no_longer_a_clients() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    place.advertise("tf_view", "tf2_msgs/TFMessage", client, None, latch=True)
    place.publish("tf_view", b"{}", client, must_arrive=True, latch=True)
    container.stream.write(
        robot_link.TopicAdded(robot_link.TopicInfo("tf_view", "tf2_msgs/TFMessage", False), "planner")
    )
    await until(lambda: "tf_view" in place.topics)
    assert place.client_topics.latched("tf_view") is None
    place.publish("tf_view", b"{}", client, must_arrive=True)
    assert isinstance(await container.next(), robot_link.Deliver)
    await container.die()


async def test_a_call_goes_to_the_client_that_offers_the_service_and_never_one_of_the_clones() -> None:
    place = PlaceLink("robot:a/r")
    provider = Client()
    number, caller = place.join(provider), place.join(Client())
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    with pytest.raises(Conflict, match="provided by the clone"):
        place.advertise_service("make_plan", "nav_msgs/GetPlan", number)
    place.advertise_service("lights", "std_srvs/SetBool", number)
    assert place.service_type("lights") == "std_srvs/SetBool"
    asked = asyncio.create_task(place.call("lights", b'{"data":true}', 5.0))
    await provider.told()
    [(call, service, payload)] = provider.calls
    assert (service, payload) == ("lights", b'{"data":true}')
    with pytest.raises(NotPermitted):
        place.client_services.answer(call, caller, b"{}")
    place.client_services.answer(call, number, b'{"success":true}')
    assert await asked == b'{"success":true}'
    await container.die()


async def test_who_called_what_the_clone_has_taken_back_from_a_client_is_told_to_call_again() -> None:
    place = PlaceLink("robot:a/r")
    robot = Client()
    number = place.join(robot)
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    for service in ("drive", "lights"):
        place.advertise_service(service, "std_srvs/Trigger", number)
    driving, lighting = (asyncio.create_task(place.call(service, b"{}", 5.0)) for service in ("drive", "lights"))
    await until(lambda: len(robot.calls) == 2)
    container.stream.write(robot_link.NodesChanged([robot_link.ServiceInfo("drive", "std_srvs/Trigger")], []))
    with pytest.raises(Unavailable, match="the clone now provides service 'drive' itself; call again"):
        await driving
    [call] = [call for call, service, _ in robot.calls if service == "lights"]
    place.client_services.answer(call, number, b"{}")
    assert await lighting == b"{}"
    again = asyncio.create_task(place.call("drive", b"{}", 5.0))
    asked = await container.next()
    assert isinstance(asked, robot_link.ServiceCall) and asked.service == "drive"
    container.stream.write(robot_link.ServiceAnswer(asked.call, b"1"))
    assert await again == b"1"
    await container.die()


async def test_a_refusal_is_told_to_the_client_that_sent_the_message_and_to_no_other() -> None:
    place = PlaceLink("robot:a/r")
    sender, other = Client(), Client()
    number = place.join(sender)
    place.join(other)
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    container.stream.write(robot_link.MessageRefused(number, "goal", robot_link.Refusal("invalid-input", "NaN")))
    await sender.told()
    assert [error.slug for error in sender.errors] == ["invalid-input"]
    assert other.errors == []
    await container.die()


async def test_a_call_is_answered_or_fails_when_its_container_is_lost() -> None:
    place = PlaceLink("robot:a/r")
    with pytest.raises(Unavailable):
        await place.call("make_plan", b"{}", 1.0)
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    answered = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    refused = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    lost = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    calls = [await container.next() for _ in range(3)]
    numbers = [call.call for call in calls if isinstance(call, robot_link.ServiceCall)]
    container.stream.write(robot_link.ServiceAnswer(numbers[0], b'{"plan":1}'))
    container.stream.write(robot_link.ServiceAnswer(numbers[1], refusal=robot_link.Refusal("no-valid-path", "none")))
    assert await answered == b'{"plan":1}'
    with pytest.raises(PPaaSError) as error:
        await refused
    assert error.value.slug == "no-valid-path"
    await container.die()
    with pytest.raises(Unavailable, match="lost"):
        await lost


async def test_what_waits_to_be_acknowledged_is_bounded() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
    for _ in range(MAX_UNACKNOWLEDGED):
        place.deliver("goal", b"1", client, must_arrive=True)
    with pytest.raises(QuotaExceeded):
        place.deliver("goal", b"1", client, must_arrive=True)


async def test_what_waits_to_be_acknowledged_is_bounded_in_bytes_too_and_there_is_room_again_afterwards() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
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


async def test_a_topic_that_nobody_hears_is_not_subscribed_to_with_the_next_container() -> None:
    place = PlaceLink("robot:a/r")
    client = place.join(Client())
    first = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    place.subscribe("map", client)
    place.unsubscribe("map", client)
    first.stream.write(robot_link.Published("map", b"{}"))  # sent before the unsubscription arrived
    first.stream.write(robot_link.Published("goal", b"{}"))
    await first.die()
    place.subscribe("goal", client)
    second = await FakeContainer.dial(place, "c2")
    await place.ready(5)
    place.unsubscribe("goal", client)
    assert [await second.next(), await second.next()] == [
        robot_link.Subscribe("goal", 0),
        robot_link.Unsubscribe("goal"),
    ]
    await second.die()


async def test_a_container_that_takes_the_place_of_one_that_still_talks_is_the_only_one_heard() -> None:
    place = PlaceLink("robot:a/r")
    listener = Client()
    client = place.join(listener)
    first = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    place.subscribe("goal", client)
    place.deliver("goal", b"1", client, must_arrive=True)
    call = asyncio.create_task(place.call("make_plan", b"{}", 5.0))
    assert [type(await first.next()) for _ in range(3)] == [
        robot_link.Subscribe,
        robot_link.Deliver,
        robot_link.ServiceCall,
    ]
    second = await FakeContainer.dial(place, "c2")
    assert [type(await second.next()) for _ in range(2)] == [robot_link.Subscribe, robot_link.Deliver]
    with pytest.raises(Unavailable, match="lost"):
        await call
    first.stream.write(robot_link.Ack(1))
    first.stream.write(robot_link.Published("goal", b"old"))
    async with asyncio.timeout(5):
        await first.serving  # its frames are ignored, and its link is closed
    second.stream.write(robot_link.Published("goal", b"new"))
    await listener.told()
    assert listener.heard == [("goal", b"new")]
    assert place.container == "c2"
    await second.die()
    third = await FakeContainer.dial(place, "c3")
    assert [type(await third.next()) for _ in range(2)] == [robot_link.Subscribe, robot_link.Deliver]
    await third.die()


async def test_whoever_asks_for_a_closed_place_learns_why_even_when_its_container_has_gone() -> None:
    place = PlaceLink("robot:a/r")
    container = await FakeContainer.dial(place, "c1")
    await place.ready(5)
    place.close(Unavailable("over"))
    assert await container.next() == robot_link.Shutdown()
    await container.die()
    with pytest.raises(Unavailable, match="over"):
        await place.ready(5)


async def test_whoever_joins_a_closed_place_is_told_at_once() -> None:
    place = PlaceLink("robot:a/r")
    place.close(Unavailable("over"))
    late = Client()
    place.leave(place.join(late))
    assert [str(reason) for reason in late.reasons] == ["over"]


async def test_closing_tells_every_client_why() -> None:
    place = PlaceLink("robot:a/r")
    listener = Client()
    place.join(listener)
    place.close(Unavailable("over"))
    assert [str(reason) for reason in listener.reasons] == ["over"]
    with pytest.raises(Unavailable, match="over"):
        await place.ready(1)
