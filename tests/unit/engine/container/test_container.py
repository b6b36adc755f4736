"""A container with its links over real sockets, and a node that the test controls: messages and calls."""

from collections.abc import AsyncIterator

import pytest

from engine.container.served_link import MAX_WAITING
from engine.protocols import robot_link
from engine.specs.containers import LINK_STATE, ContainerSpec
from ppaas.messages import decode
from ppaas.messages.base.std_msgs import String
from ppaas.messages.std_srvs import TriggerResponse
from ppaas.nodes.base import Topic
from tests.support.engine.container_peers import ContainerPeers, say
from tests.support.engine.engine_links import receive
from tests.support.engine.specs import HOUSE, robot_config, robot_spec


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
    published = await peers.ask(robot_link.Subscribe("echo", 7), say("hi"))
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
    first = await peers.ask(say("old"), say("new"), robot_link.Subscribe("last", 1))
    assert first == robot_link.Published("last", b'{"data":"new"}')
    second = await peers.ask(robot_link.Subscribe("last", 2))
    assert second == robot_link.Published("last", b'{"data":"new"}', 2)
    third = await peers.ask(say("newest"))
    assert third == robot_link.Published("last", b'{"data":"newest"}')


async def test_unsubscribed_topic_is_not_sent(peers: ContainerPeers) -> None:
    assert isinstance(await peers.ask(robot_link.Subscribe("echo", 1), say("one")), robot_link.Published)
    for frame in (
        robot_link.Unsubscribe("echo"),
        robot_link.Unsubscribe("echo"),
        robot_link.Unsubscribe("nowhere"),
        say("two"),
    ):
        peers.endpoint.write(frame)
    assert await peers.heard() == "one,two"


async def test_second_subscription_does_not_duplicate_messages(peers: ContainerPeers) -> None:
    for frame in (robot_link.Subscribe("echo", 1), robot_link.Subscribe("echo", 2), robot_link.Subscribe("nowhere", 1)):
        peers.endpoint.write(frame)
    assert await peers.ask(say("one")) == robot_link.Published("echo", b'{"data":"one"}')
    assert await peers.heard() == "one"


async def test_slow_endpoint_loses_droppable_messages_only(peers: ContainerPeers) -> None:
    peers.endpoint.write(robot_link.Subscribe("echo", 1))
    peers.endpoint.write(robot_link.Subscribe("last", 1))
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
    peers.endpoint.write(robot_link.Subscribe("repeated", 1))
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
    peers.endpoint.write(robot_link.Subscribe("fleeting", 1))
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
    peers.endpoint.write(robot_link.Unsubscribe("fleeting"))
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
