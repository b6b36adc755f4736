"""The transport over a real Zenoh session, with another node that is independent of it."""

import asyncio
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from ppaas.errors import InvalidInput, Unavailable
from ppaas.wire.ros.graph import LATCHED, Kind, Qos
from robots.bridges.zenoh import node as node_module
from robots.bridges.zenoh.node import ZenohOptions, ZenohTransport
from tests.support.ros2.zenoh_peer import LATCHED as LATCHED_TEXT
from tests.support.ros2.zenoh_peer import Peer, Recorder
from tests.support.waiting import until

STRING = "std_msgs/msg/String"
TRIGGER = "std_srvs/srv/Trigger"


def free_endpoint() -> str:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return f"tcp/127.0.0.1:{listening.getsockname()[1]}"


@pytest.fixture(autouse=True)
def _short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node_module, "GRAPH_WAIT", 0.05)


@asynccontextmanager
async def opened(endpoint: str, domain: int = 0, release: str = "jazzy") -> AsyncIterator[ZenohTransport]:
    transport = ZenohTransport(ZenohOptions(listen=(endpoint,), domain=domain, release=release))
    await transport.open(lambda: None)
    try:
        yield transport
    finally:
        await transport.close()


async def test_topics_pass_both_ways_and_late_readers_get_what_is_latched() -> None:
    endpoint = free_endpoint()
    async with opened(endpoint) as transport:
        latched = transport.publisher("/map_name", STRING, LATCHED)
        latched.publish(transport.types.encode(STRING, {"data": "office"}))
        peer = Peer(endpoint, "peer", namespace="/a")
        try:
            heard: list[str] = []
            say = peer.publisher("chatter", STRING)
            transport.subscribe(
                "/a/chatter", STRING, Qos(), lambda data: heard.append(transport.types.decode(STRING, data)["data"])
            )
            await until(lambda: [one.name for one in transport.entities()] == ["/a/chatter"])
            [talker] = transport.entities()
            assert (talker.kind, talker.type, talker.node) == (Kind.PUBLISHER, STRING, "/a/peer")

            def said() -> list[str]:
                say({"data": "hello"})
                return heard

            await until(said)
            assert heard[0] == "hello"
            root = Peer(endpoint, "late")
            received = Recorder()
            root.subscribe("map_name", STRING, received, LATCHED_TEXT)
            assert (await asyncio.to_thread(received.wait))[0]["data"] == "office"
            root.close()
            await until(lambda: len(transport.entities()) == 1)
        finally:
            peer.close()
        await until(lambda: not transport.entities())


async def test_services_are_answered_and_a_failure_ends_nothing(caplog: pytest.LogCaptureFixture) -> None:
    endpoint = free_endpoint()

    async def answer(request: bytes) -> bytes:
        return transport.types.encode(f"{TRIGGER}_Response", {"success": True, "message": "done"})

    async def fail(request: bytes) -> bytes:
        raise Unavailable("no clone")

    async with opened(endpoint) as transport:
        transport.serve("/a/dock", TRIGGER, answer)
        transport.serve("/a/fail", TRIGGER, fail)
        peer = Peer(endpoint, "peer", namespace="/a")
        try:
            response = await asyncio.to_thread(peer.call, "dock", TRIGGER, {})
            assert response == {"success": True, "message": "done"}
            with pytest.raises(TimeoutError):
                await asyncio.to_thread(peer.call, "fail", TRIGGER, {}, 2.0)
            assert "was not answered: no clone" in caplog.text
            served = [token for token in await asyncio.to_thread(peer.graph) if "/SS/" in token]
            assert any("/%a%dock/std_srvs::srv::dds_::Trigger_/RIHS01_" in token for token in served)
        finally:
            peer.close()


async def test_the_release_is_that_of_the_nodes_and_domains_are_apart() -> None:
    endpoint = free_endpoint()
    async with opened(endpoint, domain=7) as router:
        kilted = Peer(endpoint, "nav", release="kilted", domain=7)
        kilted.publisher("waypoints", "nav2_msgs/action/FollowWaypoints_GetResult")
        await until(router.entities)
        for domain, release in ((7, "kilted"), (0, "jazzy")):
            transport = ZenohTransport(ZenohOptions(connect=(endpoint,), domain=domain))
            await transport.open(lambda: None)
            try:
                await until(lambda transport=transport, seen=domain == 7: bool(transport.entities()) == seen)
                assert transport.types.release == release
            finally:
                await transport.close()
        kilted.close()


async def test_what_cannot_be_opened_is_explained(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    async with opened(endpoint):
        second = ZenohTransport(ZenohOptions(listen=(endpoint,)))
        with pytest.raises(Unavailable, match="Zenoh cannot be opened"):
            await second.open(lambda: None)
    config = tmp_path / "zenoh.json5"
    config.write_text("{mode: 'nonsense'}")
    with pytest.raises(InvalidInput, match="Zenoh cannot be configured"):
        await ZenohTransport(ZenohOptions(config=config)).open(lambda: None)
