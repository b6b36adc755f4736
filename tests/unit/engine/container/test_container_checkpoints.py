"""A container with its links over real sockets: checkpoints, and endpoints that are lost."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import ClassVar

import pytest

from engine.protocols import robot_link
from engine.protocols.framing import FrameStream
from engine.protocols.refusals import Refusal
from engine.specs.containers import LINK_STATE
from ppaas.messages.base.std_msgs import String
from ppaas.nodes.base import Node, Payload, Topic
from tests.support.engine.container_peers import ContainerPeers, say
from tests.support.engine.engine_links import receive
from tests.support.engine.specs import planning_spec, robot_spec

Endpoint = FrameStream[robot_link.FromContainer]


@pytest.fixture
async def peers() -> AsyncIterator[ContainerPeers]:
    made = await ContainerPeers(robot_spec()).start()
    yield made
    await made.close()


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
    peers.endpoint.write(robot_link.Subscribe("last", 1))
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
    peers.endpoint.write(robot_link.Subscribe("ended", 0))
    assert await peers.heard() == ""
    await peers.endpoint.close()
    peers.home.graph.inject("end", String("here"))
    peers.endpoint = await found.get()
    assert isinstance(await receive(peers.endpoint), robot_link.Hello)
    while (await peers.checkpoint())["ending"] != b"here":
        pass
    peers.endpoint.write(robot_link.Subscribe("ended", 0))
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
    peers.endpoint.write(robot_link.Subscribe("ended", 0))
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
    peers.endpoint.write(robot_link.Subscribe("ended", 0))
    peers.endpoint.write(robot_link.Deliver("end", b'{"data":"here"}', 7))
    cut_off = Refusal("conflict", "this machine has lost contact with its cloud")
    for _ in range(5):
        await peers.checkpoint(cut_off)
        assert await peers.heard() == "", "no result came before this answer"
    keeping.cancel()


async def test_result_that_waited_comes_once_after_the_checkpoint(peers: ContainerPeers) -> None:
    peers.home.graph.add(Ending)
    keeping = asyncio.create_task(peers.container.keep_checkpoints())
    peers.endpoint.write(robot_link.Subscribe("ended", 0))
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
