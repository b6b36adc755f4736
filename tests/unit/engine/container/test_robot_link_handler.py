"""A container with its links over real sockets, and a node that the test controls."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import ClassVar

import pytest

from engine.container.endpoint_link import EndpointLink
from engine.container.executor import NodeExecutor
from engine.container.machine_client import MachineClient
from engine.container.robot_link_handler import MAX_WAITING, Container
from engine.container.shared_plans import PlanningNotes
from engine.protocols import machine_link, robot_link
from engine.protocols.framing import FrameStream
from engine.specs.containers import LINK_STATE, ContainerSpec, Launch
from ppaas.messages import decode
from ppaas.messages.std_msgs import String
from ppaas.messages.std_srvs import TriggerResponse
from ppaas.nodes.base import Checkpoint, Node, Payload, Topic
from ppaas.plans.reuse.measured_times import Times
from tests.support.engine.engine_links import pair, receive
from tests.support.engine.specs import HOUSE, planning_spec, robot_config, robot_spec
from tests.support.world.echo_node import EchoNode

Endpoint = FrameStream[robot_link.FromContainer]


def launch_of(spec: ContainerSpec, layers: Path | str = "") -> Launch:
    return Launch(spec, str(layers), link="", machine="", secret="secret", cpus=(0,), threads=1)


class Outer:
    """Endpoint and machine of a container, controlled by the test frame by frame."""

    def __init__(self, spec: ContainerSpec, path: Path = Path()) -> None:
        self.spec = spec
        self._path = path

    async def start(self) -> "Outer":
        near, self.endpoint = await pair(robot_link.ToContainer, robot_link.FromContainer)
        machine, self.machine = await pair(machine_link.ToContainer, machine_link.FromContainer)
        self.home = NodeExecutor(lambda: None)
        self.node = self.home.graph.add(EchoNode)
        self.home.graph.restore([Checkpoint(name, state) for name, state in self.spec.checkpoint.items()])
        self._client = MachineClient(machine)
        self._near = near
        endpoint = EndpointLink(str(self._path), near)
        self.container = Container(launch_of(self.spec), self.home, endpoint, self._client, PlanningNotes(Times()))
        self.serving = asyncio.create_task(self.container.serve())
        self._answers = asyncio.create_task(self._client.serve(lambda _: None))
        return self

    async def ask(self, *frames: robot_link.ToContainer) -> robot_link.FromContainer:
        """Send frames, and return the next frame from the container."""
        for frame in frames:
            self.endpoint.write(frame)
        answer: robot_link.FromContainer | None = await receive(self.endpoint)
        assert answer is not None
        return answer

    async def heard(self) -> str:
        """Return what the node received, after it handled all frames sent before."""
        answer = await self.ask(robot_link.ServiceCall(99, "heard", b"{}"))
        assert isinstance(answer, robot_link.ServiceAnswer)
        return decode(TriggerResponse, answer.payload).message

    async def checkpoint(self, refusal: robot_link.Refusal | None = None) -> dict[str, bytes]:
        """Return the next checkpoint, and confirm it."""
        save = await receive(self.machine)
        assert isinstance(save, machine_link.SaveClone)
        self.machine.write(machine_link.Done(save.request, refusal))
        return save.nodes

    async def close(self) -> None:
        self.serving.cancel()
        self._answers.cancel()
        self.home.close()
        for stream in (self.endpoint, self.machine, self._near):
            await stream.close()
        await self._client.close()


@pytest.fixture
async def outer() -> AsyncIterator[Outer]:
    made = await Outer(robot_spec()).start()
    yield made
    await made.close()


def say(word: str, sequence: int = 0, client: int = 7) -> robot_link.Deliver:
    return robot_link.Deliver("say", b'{"data":"%s"}' % word.encode(), client, sequence)


# -- hello -------------------------------------------------------------------------------------------------------------


async def test_hello_lists_topics_services_and_nodes(outer: Outer) -> None:
    hello = outer.container.hello(42)
    assert (hello.container, hello.secret, hello.pid, hello.applied) == ("c1", "secret", 42, 0)
    assert robot_link.TopicInfo("say", "std_msgs/String", False) in hello.topics
    assert robot_link.TopicInfo("last", "std_msgs/String", True) in hello.topics
    services = ("heard", "refuse", "break", "job")
    assert hello.services == [robot_link.ServiceInfo(name, "std_srvs/Trigger") for name in services]
    publishes = ("echo", "last", "amcl_pose", "plan")
    assert hello.nodes == [robot_link.NodeInfo("echo", publishes, ("say", "robots"), services)]


async def test_hello_after_a_checkpoint_states_the_last_applied_message() -> None:
    checkpoint = {LINK_STATE: b"12", "echo": b"a,b"}
    outer = await Outer(ContainerSpec("c2", "ann", HOUSE, 1.0, robot_config(), checkpoint)).start()
    assert outer.container.hello(1).applied == 12
    outer.endpoint.write(say("again", 12))
    outer.endpoint.write(say("c", 13))
    assert await outer.heard() == "a,b,c"
    await outer.close()


# -- messages ----------------------------------------------------------------------------------------------------------


async def test_message_is_delivered_and_its_reaction_published(outer: Outer) -> None:
    published = await outer.ask(robot_link.Subscribe("echo", 7), say("hi"))
    assert published == robot_link.Published("echo", b'{"data":"hi"}')


async def test_repeated_message_is_applied_once(outer: Outer) -> None:
    for frame in (say("one", 1), say("two", 2), say("one", 1), say("two", 2), say("three", 3)):
        outer.endpoint.write(frame)
    assert await outer.heard() == "one,two,three"


async def test_unnumbered_messages_are_always_applied(outer: Outer) -> None:
    for frame in (say("x"), say("goal", 1), say("x")):
        outer.endpoint.write(frame)
    assert await outer.heard() == "x,goal,x"


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
async def test_refused_message_is_reported_to_its_sender(outer: Outer, frame: robot_link.Deliver, slug: str) -> None:
    refused = await outer.ask(frame)
    assert isinstance(refused, robot_link.MessageRefused)
    assert (refused.client, refused.topic, refused.refusal.slug) == (7, frame.topic, slug)
    outer.endpoint.write(say("ok"))
    assert await outer.heard() == "ok"


async def test_failing_message_counts_as_applied_and_is_not_resent(outer: Outer) -> None:
    assert isinstance(await outer.ask(say("break", 1)), robot_link.MessageRefused)
    assert outer.container.hello(1).applied == 1


# -- subscriptions -----------------------------------------------------------------------------------------------------


async def test_latched_message_is_sent_to_the_new_subscriber_only(outer: Outer) -> None:
    first = await outer.ask(say("old"), say("new"), robot_link.Subscribe("last", 1))
    assert first == robot_link.Published("last", b'{"data":"new"}')
    second = await outer.ask(robot_link.Subscribe("last", 2))
    assert second == robot_link.Published("last", b'{"data":"new"}', 2)
    third = await outer.ask(say("newest"))
    assert third == robot_link.Published("last", b'{"data":"newest"}')


async def test_unsubscribed_topic_is_not_sent(outer: Outer) -> None:
    assert isinstance(await outer.ask(robot_link.Subscribe("echo", 1), say("one")), robot_link.Published)
    for frame in (
        robot_link.Unsubscribe("echo"),
        robot_link.Unsubscribe("echo"),
        robot_link.Unsubscribe("nowhere"),
        say("two"),
    ):
        outer.endpoint.write(frame)
    assert await outer.heard() == "one,two"


async def test_second_subscription_does_not_duplicate_messages(outer: Outer) -> None:
    for frame in (robot_link.Subscribe("echo", 1), robot_link.Subscribe("echo", 2), robot_link.Subscribe("nowhere", 1)):
        outer.endpoint.write(frame)
    assert await outer.ask(say("one")) == robot_link.Published("echo", b'{"data":"one"}')
    assert await outer.heard() == "one"


async def test_slow_endpoint_loses_droppable_messages_only(outer: Outer) -> None:
    outer.endpoint.write(robot_link.Subscribe("echo", 1))
    outer.endpoint.write(robot_link.Subscribe("last", 1))
    assert await outer.heard() == ""
    word, count = "x" * 100_000, 60
    for number in range(count):
        outer.home.graph.inject("say", String(f"{number} {word}"))
    assert outer.container._endpoint.waiting > MAX_WAITING
    got: dict[str, int] = {"echo": 0, "last": 0}
    while got["last"] < count:
        frame = await receive(outer.endpoint)
        assert isinstance(frame, robot_link.Published)
        got[frame.topic] += 1
    assert got["echo"] < count / 2


async def test_topics_declared_at_run_time_are_announced_and_delivered(outer: Outer) -> None:
    graph, topic = outer.home.graph, Topic("fleeting", String)
    outer.endpoint.write(robot_link.Subscribe("fleeting", 1))
    assert await outer.heard() == ""
    for word in ("once", "again"):
        graph.declare(outer.node, topic)
        graph.publish("fleeting", String(word))
        assert await receive(outer.endpoint) == robot_link.TopicAdded(
            robot_link.TopicInfo("fleeting", "std_msgs/String", False), "echo"
        )
        assert await receive(outer.endpoint) == robot_link.Published("fleeting", b'{"data":"%s"}' % word.encode())
        assert "fleeting" in outer.container.hello(1).nodes[0].publishes
        graph.undeclare(outer.node, "fleeting")
        assert await receive(outer.endpoint) == robot_link.TopicRemoved("fleeting")
    outer.endpoint.write(robot_link.Unsubscribe("fleeting"))
    assert await outer.heard() == ""
    graph.declare(outer.node, topic)
    graph.publish("fleeting", String("unheard"))
    assert isinstance(await receive(outer.endpoint), robot_link.TopicAdded)
    assert await outer.heard() == ""


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
    outer: Outer, service: str, request_json: bytes, slug: str
) -> None:
    answer = await outer.ask(robot_link.ServiceCall(5, service, request_json))
    assert isinstance(answer, robot_link.ServiceAnswer)
    assert answer.call == 5
    assert answer.refusal is not None
    assert answer.refusal.slug == slug
    assert await outer.heard() == ""


async def test_pending_call_does_not_delay_messages(outer: Outer) -> None:
    outer.node.job_may_end.clear()
    outer.endpoint.write(robot_link.ServiceCall(1, "job", b"{}"))
    outer.endpoint.write(say("meanwhile"))
    assert await outer.heard() == "meanwhile"
    outer.node.job_may_end.set()
    answer = await receive(outer.endpoint)
    assert isinstance(answer, robot_link.ServiceAnswer)
    assert answer.call == 1
    assert decode(TriggerResponse, answer.payload).message.startswith("job")


# -- checkpoints -------------------------------------------------------------------------------------------------------


async def test_shutdown_saves_a_checkpoint_and_ends(outer: Outer) -> None:
    outer.endpoint.write(say("one", 1))
    outer.endpoint.write(robot_link.Shutdown())
    assert await outer.checkpoint() == {"echo": b"one", LINK_STATE: b"1"}
    assert await receive(outer.endpoint) == robot_link.Ack(1)
    await asyncio.wait_for(outer.serving, 10)


@pytest.fixture
async def served_twice(tmp_path: Path) -> AsyncIterator[tuple[Outer, "asyncio.Queue[Endpoint]"]]:
    """Return a container whose endpoint may disconnect, and the endpoints that it dials then."""
    found: asyncio.Queue[Endpoint] = asyncio.Queue()
    path = tmp_path / "link.sock"
    server = await asyncio.start_unix_server(
        lambda *streams: found.put_nowait(FrameStream(*streams, robot_link.FromContainer)), path
    )
    made = await Outer(robot_spec(), path).start()
    yield made, found
    server.close()
    while not found.empty():
        await found.get_nowait().close()
    await made.close()


async def test_container_redials_a_lost_endpoint_and_drops_subscriptions(
    served_twice: tuple[Outer, "asyncio.Queue[Endpoint]"],
) -> None:
    outer, found = served_twice
    outer.endpoint.write(robot_link.Subscribe("last", 1))
    assert await outer.ask(say("one", 57)) == robot_link.Published("last", b'{"data":"one"}')
    await outer.endpoint.close()
    outer.endpoint = await found.get()
    hello = await receive(outer.endpoint)
    assert isinstance(hello, robot_link.Hello) and (hello.container, hello.applied) == (outer.spec.id, 57)
    assert {topic.name for topic in hello.topics} == set(outer.home.graph.topics)
    outer.endpoint.write(say("two", 58))
    assert await outer.heard() == "one,two", "the container is the same, and no topic is subscribed"
    assert not outer.serving.done()


async def test_answer_for_a_lost_endpoint_is_not_sent_to_the_next(
    served_twice: tuple[Outer, "asyncio.Queue[Endpoint]"],
) -> None:
    outer, found = served_twice
    outer.node.job_may_end.clear()
    outer.endpoint.write(robot_link.ServiceCall(1, "job", b"{}"))
    assert await outer.heard() == ""
    await outer.endpoint.close()
    outer.endpoint = await found.get()
    assert isinstance(await receive(outer.endpoint), robot_link.Hello)
    outer.node.job_may_end.set()
    answer = await outer.ask(robot_link.ServiceCall(2, "job", b"{}"))
    assert isinstance(answer, robot_link.ServiceAnswer) and answer.call == 2


async def test_result_without_an_endpoint_is_sent_to_the_next_subscriber(
    served_twice: tuple[Outer, "asyncio.Queue[Endpoint]"],
) -> None:
    outer, found = served_twice
    outer.home.graph.add(Ending)
    keeping = asyncio.create_task(outer.container.keep_checkpoints())
    outer.endpoint.write(robot_link.Subscribe("ended", 0))
    assert await outer.heard() == ""
    await outer.endpoint.close()
    outer.home.graph.inject("end", String("here"))
    outer.endpoint = await found.get()
    assert isinstance(await receive(outer.endpoint), robot_link.Hello)
    while (await outer.checkpoint())["ending"] != b"here":
        pass
    outer.endpoint.write(robot_link.Subscribe("ended", 0))
    while not isinstance(frame := await receive(outer.endpoint), robot_link.Published):
        assert isinstance(frame, robot_link.Ack)
    assert frame == robot_link.Published("ended", b'{"data":"here"}')
    keeping.cancel()


async def test_message_is_acknowledged_after_its_checkpoint(outer: Outer) -> None:
    keeping = asyncio.create_task(outer.container.keep_checkpoints())
    outer.endpoint.write(say("one", 1))
    nodes = await outer.checkpoint(robot_link.Refusal("unavailable", "the disk is full"))
    while nodes[LINK_STATE] != b"1":
        nodes = await outer.checkpoint(robot_link.Refusal("unavailable", "the disk is full"))
    assert await outer.heard() == "one"  # and no Ack arrived before this answer
    assert (await outer.checkpoint())["echo"] == b"one"
    assert await receive(outer.endpoint) == robot_link.Ack(1)
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


@pytest.mark.parametrize("refusal", [None, robot_link.Refusal("unavailable", "the disk is full")])
async def test_result_is_published_after_the_checkpoint_was_tried(
    outer: Outer, refusal: robot_link.Refusal | None
) -> None:
    outer.home.graph.add(Ending)
    keeping = asyncio.create_task(outer.container.keep_checkpoints())
    outer.endpoint.write(robot_link.Subscribe("ended", 0))
    outer.endpoint.write(robot_link.Deliver("end", b'{"data":"here"}', 7))
    assert await outer.heard() == ""  # and it was not published before this answer
    while (await outer.checkpoint(refusal))["ending"] != b"here":
        assert await receive(outer.endpoint) == robot_link.Ack(0)
    if refusal is None:
        assert await receive(outer.endpoint) == robot_link.Ack(0)
    assert await receive(outer.endpoint) == robot_link.Published("ended", b'{"data":"here"}')
    keeping.cancel()


async def test_planning_container_saves_no_checkpoint() -> None:
    outer = await Outer(planning_spec()).start()
    outer.endpoint.write(robot_link.Shutdown())
    await asyncio.wait_for(outer.serving, 10)
    await outer.machine.close()
    await outer.close()
