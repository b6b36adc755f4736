"""A container dials endpoints, played by the test at real sockets, and again one that has exited."""

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from engine.container import endpoint_links
from engine.container.endpoint_links import EndpointLink
from engine.protocols import robot_link
from engine.protocols.address import EndpointAddress
from engine.protocols.framing import FrameStream
from tests.support.engine.container_peers import ContainerPeers, say
from tests.support.engine.engine_links import hello, pair, receive
from tests.support.engine.specs import robot_spec
from tests.support.waiting import patience, until

PLACE = "robot:ann/tb1"
ECHO = robot_link.Published("echo", b'{"data":"hi"}')


def dial_order(name: str, address: str, generation: int = 1, machine: str = "") -> robot_link.DialEndpoint:
    """Return the order to dial an endpoint."""
    return robot_link.DialEndpoint(
        endpoint=name,
        at=EndpointAddress(machine, address, "tls://host:7000", "f1"),
        place=PLACE,
        generation=generation,
        secret=f"secret {generation} of {name}",
    )


class Endpoint:
    """Endpoint that listens at a Unix socket, or the relay to it, which first reads the addresses."""

    def __init__(self, path: Path, name: str = "e1", *, relays: bool = False) -> None:
        self.name = name
        self.path = path
        self.asked: list[str] = []
        self._relays = relays
        self._arrived: asyncio.Queue[FrameStream[Any]] = asyncio.Queue()
        self._server: asyncio.Server | None = None
        self._streams: list[FrameStream[Any]] = []

    async def listen(self) -> "Endpoint":
        self._server = await asyncio.start_unix_server(self._connected, self.path)
        return self

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        if self._relays:
            self.asked.append((await reader.readline()).decode().strip())
        stream: FrameStream[Any] = FrameStream(reader, writer, robot_link.FromContainer)
        self._streams.append(stream)
        self._arrived.put_nowait(stream)

    @property
    def order(self) -> robot_link.DialEndpoint:
        """Order to dial this endpoint."""
        return dial_order(self.name, f"unix:{self.path}")

    async def welcomed(self, generation: int = 1) -> FrameStream[Any]:
        """Return the next link of the container, whose first frame must be the right hello."""
        async with patience(10.0):
            stream = await self._arrived.get()
        hello = await receive(stream)
        assert isinstance(hello, robot_link.Hello)
        assert (hello.container, hello.place, hello.generation) == ("c1", PLACE, generation)
        assert hello.secret == f"secret {generation} of {self.name}"
        assert (hello.applied, "say" in [topic.name for topic in hello.topics]) == (0, True)
        return stream

    @property
    def dials(self) -> int:
        """Number of times that the container has dialled."""
        return len(self._streams)

    async def close(self) -> None:
        if self._server is not None:
            self._server.close()
        for stream in self._streams:
            await stream.close()


async def check_served(stream: FrameStream[Any]) -> None:
    """Check that a link is served: it is subscribed to a topic, and sends a message."""
    stream.write(robot_link.SubscribeTopic("echo", 7))
    stream.write(say("hi"))
    assert await receive(stream) == ECHO


@pytest.fixture
async def peers(monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[ContainerPeers]:
    monkeypatch.setattr(endpoint_links, "RETRY", 0.01)
    made = await ContainerPeers(robot_spec()).start()
    yield made
    await made.container.endpoints.close()
    await made.close()


@pytest.fixture
async def endpoint(short_path: Path) -> AsyncIterator[Endpoint]:
    made = await Endpoint(short_path / "e1.sock").listen()
    yield made
    await made.close()


async def test_container_greets_and_serves_an_endpoint(peers: ContainerPeers, endpoint: Endpoint) -> None:
    peers.endpoint.write(endpoint.order)
    await check_served(await endpoint.welcomed())
    assert peers.container.endpoints.any_up
    assert await peers.heard() == "hi", "the master's link is served, too, and gets no message of another link"


async def test_several_endpoints_hear_what_they_are_subscribed_to(
    peers: ContainerPeers, endpoint: Endpoint, short_path: Path
) -> None:
    other = await Endpoint(short_path / "e2.sock", "e2").listen()
    for each in (endpoint, other):
        peers.endpoint.write(each.order)
    first, second = await endpoint.welcomed(), await other.welcomed()
    second.write(robot_link.SubscribeTopic("echo", 3))
    second.write(robot_link.ServiceCall(1, "heard", b"{}"))
    assert isinstance(await receive(second), robot_link.ServiceAnswer)
    await check_served(first)
    assert await receive(second) == ECHO
    await other.close()


async def test_a_repeated_order_dials_once(peers: ContainerPeers, endpoint: Endpoint) -> None:
    for _ in range(3):
        peers.endpoint.write(endpoint.order)
    await check_served(await endpoint.welcomed())
    assert await peers.heard() == "hi"
    assert endpoint.dials == 1


async def test_an_endpoint_may_listen_later(peers: ContainerPeers, short_path: Path) -> None:
    late = Endpoint(short_path / "late.sock")
    peers.endpoint.write(late.order)
    assert await peers.heard() == ""
    assert not peers.container.endpoints.any_up
    await late.listen()
    await check_served(await late.welcomed())
    await late.close()


async def test_container_dials_again_after_a_lost_link(peers: ContainerPeers, endpoint: Endpoint) -> None:
    peers.endpoint.write(endpoint.order)
    for _ in range(2):
        stream = await endpoint.welcomed()
        await check_served(stream)
        stream.abort()
    again = await endpoint.welcomed()
    again.write(robot_link.ServiceCall(1, "heard", b"{}"))
    answer = await receive(again)
    assert isinstance(answer, robot_link.ServiceAnswer), "subscriptions ended with the lost links"
    assert await peers.heard() == "hi,hi"


async def test_shutdown_from_an_endpoint_ends_its_link_only(peers: ContainerPeers, endpoint: Endpoint) -> None:
    peers.endpoint.write(endpoint.order)
    stream = await endpoint.welcomed()
    stream.write(robot_link.Shutdown())
    assert await receive(stream) is None
    await until(lambda: not peers.container.endpoints.any_up)
    assert await peers.heard() == ""
    assert not peers.serving.done()
    assert endpoint.dials == 1
    peers.endpoint.write(endpoint.order)
    await check_served(await endpoint.welcomed())


async def test_container_leaves_an_endpoint_at_the_masters_order(peers: ContainerPeers, endpoint: Endpoint) -> None:
    peers.endpoint.write(endpoint.order)
    stream = await endpoint.welcomed()
    peers.endpoint.write(robot_link.LeaveEndpoint("another"))
    await check_served(stream)
    peers.endpoint.write(robot_link.LeaveEndpoint(endpoint.name))
    assert await receive(stream) is None
    await until(lambda: not peers.container.endpoints.any_up)
    assert await peers.heard() == "hi"
    assert endpoint.dials == 1


async def test_container_gives_up_an_endpoint_that_is_gone_until_the_next_order(
    peers: ContainerPeers, short_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(endpoint_links, "ATTEMPTS", 3)
    gone = Endpoint(short_path / "gone.sock")
    peers.endpoint.write(gone.order)
    await until(lambda: "endpoint e1 does not answer any more" in caplog.text)
    await gone.listen()
    peers.endpoint.write(gone.order)
    await check_served(await gone.welcomed())
    await gone.close()


async def test_an_order_of_another_generation_dials_anew(peers: ContainerPeers, endpoint: Endpoint) -> None:
    peers.endpoint.write(endpoint.order)
    first = await endpoint.welcomed()
    peers.endpoint.write(dial_order(endpoint.name, endpoint.order.at.near, generation=2))
    assert await receive(first) is None
    await check_served(await endpoint.welcomed(generation=2))
    assert endpoint.dials == 2


@pytest.mark.parametrize("machine", ["", "hall-2"])
async def test_endpoints_of_other_machines_or_out_of_sight_are_dialled_by_the_relay_of_the_machine(
    peers: ContainerPeers, endpoint: Endpoint, short_path: Path, monkeypatch: pytest.MonkeyPatch, machine: str
) -> None:
    relay = await Endpoint(short_path / "relay.sock", "e9", relays=True).listen()
    monkeypatch.setattr(peers.container.endpoints, "_relay", relay.path)
    address = f"unix:{endpoint.path}" if machine else "unix:/of/another/host.sock"
    order = dial_order("e9", address, machine=machine)
    peers.endpoint.write(order)
    await check_served(await relay.welcomed())
    assert [msgspec.json.decode(line, type=EndpointAddress) for line in relay.asked] == [order.at]
    await relay.close()


async def test_closing_ends_all_links(peers: ContainerPeers, endpoint: Endpoint) -> None:
    peers.endpoint.write(endpoint.order)
    stream = await endpoint.welcomed()
    await peers.container.endpoints.close()
    assert await receive(stream) is None
    assert not peers.container.endpoints.any_up


HELLO = hello("c1", "secret")


class Endpoints:
    """Endpoints that listen at one address, one after another."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._arrived: asyncio.Queue[FrameStream[Any]] = asyncio.Queue()

    async def listen(self) -> asyncio.Server:
        """Start another endpoint."""
        return await asyncio.start_unix_server(self._connected, self._path)

    async def _connected(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._arrived.put_nowait(FrameStream(reader, writer, robot_link.FromContainer))

    async def arrived(self) -> FrameStream[Any]:
        """Return the connection of the container, after it has dialled."""
        async with patience(10.0):
            return await self._arrived.get()


class Linked:
    """Container that has lost its endpoint, and without a notification dials after a minute only."""

    def __init__(self, endpoint: EndpointLink, endpoints: Endpoints) -> None:
        self.endpoint = endpoint
        self.endpoints = endpoints
        self.losses = 0

    def lost(self) -> None:
        """Count the lost connections."""
        self.losses += 1


@pytest.fixture
async def linked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AsyncIterator[Linked]:
    monkeypatch.setattr("engine.container.endpoint_links.RETRIES", (60.0,))
    near, far = await pair(robot_link.ToContainer, robot_link.FromContainer)
    made = Linked(EndpointLink(str(tmp_path / "link.sock"), near), Endpoints(tmp_path / "link.sock"))
    serving = asyncio.create_task(made.endpoint.serve(lambda _: True, lambda: HELLO, made.lost))
    await far.close()
    yield made
    serving.cancel()
    await asyncio.gather(serving, return_exceptions=True)
    await made.endpoint.close()


async def test_container_redials_when_notified_of_an_endpoint(linked: Linked) -> None:
    server = await linked.endpoints.listen()
    linked.endpoint.came()
    arrived = await linked.endpoints.arrived()
    assert await receive(arrived) == HELLO
    assert linked.endpoint.is_up and linked.losses == 1
    await arrived.close()
    linked.endpoint.came()
    again = await linked.endpoints.arrived()
    assert await receive(again) == HELLO
    assert linked.losses == 2
    await again.close()
    server.close()


async def test_container_keeps_waiting_if_the_endpoint_does_not_answer(linked: Linked) -> None:
    linked.endpoint.came()
    while linked.endpoint._came.is_set():
        await asyncio.sleep(0)
    assert not linked.endpoint.is_up
    server = await linked.endpoints.listen()
    linked.endpoint.came()
    arrived = await linked.endpoints.arrived()
    assert await receive(arrived) == HELLO
    await arrived.close()
    server.close()
