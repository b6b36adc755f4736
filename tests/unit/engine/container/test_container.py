"""A container with its links over real sockets, and a node that the test controls: messages, calls, checkpoints."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import ClassVar

import pytest

from engine.container.endpoint_links import MAX_WAITING
from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal
from engine.specs.containers import LINK_STATE, ContainerSpec
from ppaas.messages import decode
from ppaas.messages.base.std_msgs import String
from ppaas.messages.std_srvs import TriggerResponse
from ppaas.nodes.base import Node, Payload, Topic
from tests.support.engine.container_peers import ContainerPeers, say
from tests.support.engine.engine_links import receive
from tests.support.engine.specs import HOUSE, planning_spec, robot_config, robot_spec


@pytest.fixture
async def peers() -> AsyncIterator[ContainerPeers]:
    made = await ContainerPeers(robot_spec()).start()
    yield made
    await made.close()


# -- hello -------------------------------------------------------------------------------------------------------------


async def test_hello_lists_topics_services_and_nodes(peers: ContainerPeers) -> None:
    hello = peers.container.hello(42)
    assert (hello.container, hello.secret, hello.pid, hello.applied) == ("c1", "secret", 42, 0)
    assert robot_link.TopicInfo("say", "std_msgs/String", False) in hello.topics
    assert robot_link.TopicInfo("last", "std_msgs/String", True) in hello.topics
    services = ("heard", "refuse", "break", "job")
    assert hello.services == [robot_link.ServiceInfo(name, "std_srvs/Trigger") for name in services]
    publishes = ("echo", "last", "amcl_pose", "plan")
    assert hello.nodes == [robot_link.NodeInfo("echo", publishes, ("say", "robots"), services)]


async def test_hello_after_a_checkpoint_states_the_last_applied_message() -> None:
    checkpoint = {LINK_STATE: b"12", "echo": b"a,b"}
    peers = await ContainerPeers(ContainerSpec("c2", "ann", HOUSE, 1.0, robot_config(), checkpoint)).start()
    assert peers.container.hello(1).applied == 12
    peers.endpoint.write(say("again", 12))
    peers.endpoint.write(say("c", 13))
    assert await peers.heard() == "a,b,c"
    await peers.close()


# -- messages ----------------------------------------------------------------------------------------------------------


async def test_message_is_delivered_and_its_reaction_published(peers: ContainerPeers) -> None:
    published = await peers.ask(robot_link.SubscribeTopic("echo", 7), say("hi"))
    assert published == robot_link.Published("echo", b'{"data":"hi"}')


async def test_repeated_message_is_applied_once(peers: ContainerPeers) -> None:
    for frame in (say("one", 1), say("two", 2), say("one", 1), say("two", 2), say("three", 3)):
        peers.endpoint.write(frame)
    assert await peers.heard() == "one,two,three"


async def test_unnumbered_messages_are_always_applied(peers: ContainerPeers) -> None:
    for frame in (say("x"), say("goal", 1), say("x")):
        peers.endpoint.write(frame)
    assert await peers.heard() == "x,goal,x"


@pytest.mark.parametrize(
    ("frame", "slug"),
    [
        (say("refuse"), "invalid-input"),
        (robot_link.Deliver("nowhere", b"{}", 7), "not-found"),
        (robot_link.Deliver("say", b"{", 7), "malformed-message"),
        (robot_link.Deliver("say", b"\xff", 7), "malformed-message"),
        (robot_link.Deliver("say", b'{"data":1}', 7), "malformed-message"),
        (say("break"), "error"),
    ],
    ids=["refused", "unknown topic", "cut off", "no text", "wrong type", "poison"],
)
async def test_refused_message_is_reported_to_its_sender(
    peers: ContainerPeers, frame: robot_link.Deliver, slug: str
) -> None:
    refused = await peers.ask(frame)
    assert isinstance(refused, robot_link.MessageRefused)
    assert (refused.client, refused.topic, refused.refusal.slug) == (7, frame.topic, slug)
    peers.endpoint.write(say("ok"))
    assert await peers.heard() == "ok"


async def test_failing_message_counts_as_applied_and_is_not_resent(peers: ContainerPeers) -> None:
    assert isinstance(await peers.ask(say("break", 1)), robot_link.MessageRefused)
    assert peers.container.hello(1).applied == 1


# -- subscriptions -----------------------------------------------------------------------------------------------------


async def test_latched_message_is_sent_to_the_new_subscriber_only(peers: ContainerPeers) -> None:
    first = await peers.ask(say("old"), say("new"), robot_link.SubscribeTopic("last", 1))
    assert first == robot_link.Published("last", b'{"data":"new"}')
    second = await peers.ask(robot_link.SubscribeTopic("last", 2))
    assert second == robot_link.Published("last", b'{"data":"new"}', 2)
    third = await peers.ask(say("newest"))
    assert third == robot_link.Published("last", b'{"data":"newest"}')


async def test_unsubscribed_topic_is_not_sent(peers: ContainerPeers) -> None:
    assert isinstance(await peers.ask(robot_link.SubscribeTopic("echo", 1), say("one")), robot_link.Published)
    for frame in (
        robot_link.UnsubscribeTopic("echo"),
        robot_link.UnsubscribeTopic("echo"),
        robot_link.UnsubscribeTopic("nowhere"),
        say("two"),
    ):
        peers.endpoint.write(frame)
    assert await peers.heard() == "one,two"


async def test_second_subscription_does_not_duplicate_messages(peers: ContainerPeers) -> None:
    for frame in (
        robot_link.SubscribeTopic("echo", 1),
        robot_link.SubscribeTopic("echo", 2),
        robot_link.SubscribeTopic("nowhere", 1),
    ):
        peers.endpoint.write(frame)
    assert await peers.ask(say("one")) == robot_link.Published("echo", b'{"data":"one"}')
    assert await peers.heard() == "one"


async def test_slow_endpoint_loses_droppable_messages_only(peers: ContainerPeers) -> None:
    peers.endpoint.write(robot_link.SubscribeTopic("echo", 1))
    peers.endpoint.write(robot_link.SubscribeTopic("last", 1))
    assert await peers.heard() == ""
    word, count = "x" * 100_000, 60
    for number in range(count):
        peers.home.graph.inject("say", String(f"{number} {word}"))
    assert peers.container._endpoint.waiting > MAX_WAITING
    got: dict[str, int] = {"echo": 0, "last": 0}
    while got["last"] < count:
        frame = await receive(peers.endpoint)
        assert isinstance(frame, robot_link.Published)
        got[frame.topic] += 1
    assert got["echo"] < count / 2


async def test_slow_endpoint_loses_latched_messages_of_topics_that_repeat_them(peers: ContainerPeers) -> None:
    graph, topic = peers.home.graph, Topic("repeated", String, latched=True, stream=True, repeated=True)
    graph.declare(peers.node, topic)
    peers.endpoint.write(robot_link.SubscribeTopic("repeated", 1))
    assert isinstance(await receive(peers.endpoint), robot_link.TopicAdded)
    assert await peers.heard() == ""
    for number in range(60):
        graph.publish("repeated", String(f"{number} {'x' * 100_000}"))
    assert MAX_WAITING < peers.container._endpoint.waiting < 2 * MAX_WAITING
    peers.endpoint.write(robot_link.ServiceCall(99, "heard", b"{}"))
    got = 0
    while isinstance(await receive(peers.endpoint), robot_link.Published):
        got += 1
    assert 0 < got < 30


async def test_topics_declared_at_run_time_are_announced_and_delivered(peers: ContainerPeers) -> None:
    graph, topic = peers.home.graph, Topic("fleeting", String)
    peers.endpoint.write(robot_link.SubscribeTopic("fleeting", 1))
    assert await peers.heard() == ""
    for word in ("once", "again"):
        graph.declare(peers.node, topic)
        graph.publish("fleeting", String(word))
        assert await receive(peers.endpoint) == robot_link.TopicAdded(
            robot_link.TopicInfo("fleeting", "std_msgs/String", False), "echo"
        )
        assert await receive(peers.endpoint) == robot_link.Published("fleeting", b'{"data":"%s"}' % word.encode())
        assert "fleeting" in peers.container.hello(1).nodes[0].publishes
        graph.undeclare(peers.node, "fleeting")
        assert await receive(peers.endpoint) == robot_link.TopicRemoved("fleeting")
    peers.endpoint.write(robot_link.UnsubscribeTopic("fleeting"))
    assert await peers.heard() == ""
    graph.declare(peers.node, topic)
    graph.publish("fleeting", String("unheard"))
    assert isinstance(await receive(peers.endpoint), robot_link.TopicAdded)
    assert await peers.heard() == ""


# -- calls -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("service", "request_json", "slug"),
    [
        ("nowhere", b"{}", "not-found"),
        ("heard", b"[1,2,3]", "malformed-message"),
        ("refuse", b"{}", "invalid-input"),
        ("break", b"{}", "error"),
    ],
)
async def test_failed_call_is_answered_with_a_refusal(
    peers: ContainerPeers, service: str, request_json: bytes, slug: str
) -> None:
    answer = await peers.ask(robot_link.ServiceCall(5, service, request_json))
    assert isinstance(answer, robot_link.ServiceAnswer)
    assert answer.call == 5
    assert answer.refusal is not None
    assert answer.refusal.slug == slug
    assert await peers.heard() == ""


async def test_pending_call_does_not_delay_messages(peers: ContainerPeers) -> None:
    peers.node.job_may_end.clear()
    peers.endpoint.write(robot_link.ServiceCall(1, "job", b"{}"))
    peers.endpoint.write(say("meanwhile"))
    assert await peers.heard() == "meanwhile"
    peers.node.job_may_end.set()
    answer = await receive(peers.endpoint)
    assert isinstance(answer, robot_link.ServiceAnswer)
    assert answer.call == 1
    assert decode(TriggerResponse, answer.payload).message.startswith("job")


Endpoint = FrameStream[robot_link.FromContainer]


async def test_shutdown_saves_a_checkpoint_and_ends(peers: ContainerPeers) -> None:
    peers.endpoint.write(say("one", 1))
    peers.endpoint.write(robot_link.Shutdown())
    assert await peers.checkpoint() == {"echo": b"one", LINK_STATE: b"1"}
    assert await receive(peers.endpoint) == robot_link.Ack(1)
    await asyncio.wait_for(peers.serving, 10)


@pytest.fixture
async def served_twice(tmp_path: Path) -> AsyncIterator[tuple[ContainerPeers, "asyncio.Queue[Endpoint]"]]:
    """Return a container whose endpoint may disconnect, and the endpoints that it dials then."""
    found: asyncio.Queue[Endpoint] = asyncio.Queue()
    path = tmp_path / "link.sock"
    server = await asyncio.start_unix_server(
        lambda *streams: found.put_nowait(FrameStream(*streams, robot_link.FromContainer)), path
    )
    made = await ContainerPeers(robot_spec(), path).start()
    yield made, found
    server.close()
    while not found.empty():
        await found.get_nowait().close()
    await made.close()


async def test_container_redials_a_lost_endpoint_and_drops_subscriptions(
    served_twice: tuple[ContainerPeers, "asyncio.Queue[Endpoint]"],
) -> None:
    peers, found = served_twice
    peers.endpoint.write(robot_link.SubscribeTopic("last", 1))
    assert await peers.ask(say("one", 57)) == robot_link.Published("last", b'{"data":"one"}')
    await peers.endpoint.close()
    peers.endpoint = await found.get()
    hello = await receive(peers.endpoint)
    assert isinstance(hello, robot_link.Hello) and (hello.container, hello.applied) == (peers.spec.id, 57)
    assert {topic.name for topic in hello.topics} == set(peers.home.graph.topics)
    peers.endpoint.write(say("two", 58))
    assert await peers.heard() == "one,two", "the container is the same, and no topic is subscribed"
    assert not peers.serving.done()


async def test_answer_for_a_lost_endpoint_is_not_sent_to_the_next(
    served_twice: tuple[ContainerPeers, "asyncio.Queue[Endpoint]"],
) -> None:
    peers, found = served_twice
    peers.node.job_may_end.clear()
    peers.endpoint.write(robot_link.ServiceCall(1, "job", b"{}"))
    assert await peers.heard() == ""
    await peers.endpoint.close()
    peers.endpoint = await found.get()
    assert isinstance(await receive(peers.endpoint), robot_link.Hello)
    peers.node.job_may_end.set()
    answer = await peers.ask(robot_link.ServiceCall(2, "job", b"{}"))
    assert isinstance(answer, robot_link.ServiceAnswer) and answer.call == 2


async def test_result_without_an_endpoint_is_sent_to_the_next_subscriber(
    served_twice: tuple[ContainerPeers, "asyncio.Queue[Endpoint]"],
) -> None:
    peers, found = served_twice
    peers.home.graph.add(Ending)
    keeping = asyncio.create_task(peers.container.keep_checkpoints())
    peers.endpoint.write(robot_link.SubscribeTopic("ended", 0))
    assert await peers.heard() == ""
    await peers.endpoint.close()
    peers.home.graph.inject("end", String("here"))
    peers.endpoint = await found.get()
    assert isinstance(await receive(peers.endpoint), robot_link.Hello)
    while (await peers.checkpoint())["ending"] != b"here":
        pass
    peers.endpoint.write(robot_link.SubscribeTopic("ended", 0))
    while not isinstance(frame := await receive(peers.endpoint), robot_link.Published):
        assert isinstance(frame, robot_link.Ack)
    assert frame == robot_link.Published("ended", b'{"data":"here"}')
    keeping.cancel()


async def test_message_is_acknowledged_after_its_checkpoint(peers: ContainerPeers) -> None:
    keeping = asyncio.create_task(peers.container.keep_checkpoints())
    peers.endpoint.write(say("one", 1))
    nodes = await peers.checkpoint(Refusal("unavailable", "the disk is full"))
    while nodes[LINK_STATE] != b"1":
        nodes = await peers.checkpoint(Refusal("unavailable", "the disk is full"))
    assert await peers.heard() == "one"  # and no Ack arrived before this answer
    assert (await peers.checkpoint())["echo"] == b"one"
    assert await receive(peers.endpoint) == robot_link.Ack(1)
    keeping.cancel()


class Ending(Node):
    """Node that publishes on ``ended`` what it receives on ``end``, and stores it in its checkpoint."""

    name: ClassVar[str] = "ending"
    subscribes: ClassVar[tuple[Topic, ...]] = (Topic("end", String),)
    publishes: ClassVar[tuple[Topic, ...]] = (Topic("ended", String, published_once=True),)
    received = b""

    def on_message(self, topic: str, message: Payload) -> None:
        assert isinstance(message, String)
        self.received = message.data.encode()
        self.context.publish("ended", message)

    def checkpoint(self) -> bytes:
        return self.received


@pytest.mark.parametrize("refusal", [None, Refusal("unavailable", "the disk is full")])
async def test_result_is_published_after_the_checkpoint_was_tried(
    peers: ContainerPeers, refusal: Refusal | None
) -> None:
    peers.home.graph.add(Ending)
    keeping = asyncio.create_task(peers.container.keep_checkpoints())
    peers.endpoint.write(robot_link.SubscribeTopic("ended", 0))
    peers.endpoint.write(robot_link.Deliver("end", b'{"data":"here"}', 7))
    assert await peers.heard() == ""  # and it was not published before this answer
    while (await peers.checkpoint(refusal))["ending"] != b"here":
        assert await receive(peers.endpoint) == robot_link.Ack(0)
    if refusal is None:
        assert await receive(peers.endpoint) == robot_link.Ack(0)
    assert await receive(peers.endpoint) == robot_link.Published("ended", b'{"data":"here"}')
    keeping.cancel()


async def test_result_waits_as_long_as_another_container_may_serve_the_robot(peers: ContainerPeers) -> None:
    peers.home.graph.add(Ending)
    keeping = asyncio.create_task(peers.container.keep_checkpoints())
    peers.endpoint.write(robot_link.SubscribeTopic("ended", 0))
    peers.endpoint.write(robot_link.Deliver("end", b'{"data":"here"}', 7))
    cut_off = Refusal("conflict", "this machine has lost contact with its cloud")
    for _ in range(5):
        await peers.checkpoint(cut_off)
        assert await peers.heard() == "", "no result came before this answer"
    keeping.cancel()


async def test_result_that_waited_comes_once_after_the_checkpoint(peers: ContainerPeers) -> None:
    peers.home.graph.add(Ending)
    keeping = asyncio.create_task(peers.container.keep_checkpoints())
    peers.endpoint.write(robot_link.SubscribeTopic("ended", 0))
    peers.endpoint.write(robot_link.Deliver("end", b'{"data":"here"}', 7))
    assert await peers.heard() == ""
    while (await peers.checkpoint(Refusal("conflict", "cut off")))["ending"] != b"here":
        pass
    assert (await peers.checkpoint())["ending"] == b"here"
    assert await receive(peers.endpoint) == robot_link.Ack(0)
    assert await receive(peers.endpoint) == robot_link.Published("ended", b'{"data":"here"}')
    assert (await peers.checkpoint())["ending"] == b"here"
    assert await receive(peers.endpoint) == robot_link.Ack(0)
    keeping.cancel()


async def test_planning_container_saves_no_checkpoint() -> None:
    peers = await ContainerPeers(planning_spec()).start()
    peers.endpoint.write(robot_link.Shutdown())
    await asyncio.wait_for(peers.serving, 10)
    await peers.machine.close()
    await peers.close()
