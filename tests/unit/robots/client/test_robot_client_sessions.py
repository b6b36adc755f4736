"""Sessions of the client: resumption after a reconnect, and new sessions."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Iterator
from typing import Any
from urllib.parse import parse_qs, urlsplit

import msgspec
import pytest

from ppaas.errors import Conflict, Unavailable
from ppaas.messages.base.message import Empty, Message
from ppaas.messages.base.std_msgs import Float64, String
from ppaas.messages.std_srvs import Trigger, TriggerResponse
from ppaas.wire.resumption import ENDPOINT_HEADER, ID_HEADER, LEFT, STATE_HEADER, TAKEN_HEADER
from robots.client.connection import Address
from robots.client.robot_client import RobotClient
from robots.client.subscription import SubscriptionRegistry, TopicSubscription
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.waiting import until


def at_once() -> Iterator[float]:
    return itertools.repeat(0.01)


def session_headers(state: str, session: str = "s1", taken: int = 0) -> dict[str, str]:
    return {STATE_HEADER: state, ID_HEADER: session, TAKEN_HEADER: str(taken)}


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        running.headers = session_headers("new")
        yield running


def client_of(server: RosbridgeServer, **options: Any) -> RobotClient:
    return RobotClient(server.url, robot="tb1", token="t", **{"reconnect_delays": at_once, **options})


def resumption_points(server: RosbridgeServer) -> list[str]:
    """Return the resumption point that the client sent with each connection."""
    return [parse_qs(urlsplit(path).query)["resume"][0] for path in server.paths]


async def reconnect(server: RosbridgeServer, headers: dict[str, str]) -> None:
    """Break the connection; the server answers the next one differently."""
    count = len(server.connections)
    server.headers = headers
    server.connections[-1].transport.abort()
    await server.connected(count + 1)


async def test_each_client_keeps_a_unique_session_name(server: RosbridgeServer) -> None:
    async with client_of(server), client_of(server):
        await reconnect(server, session_headers("new"))
    names = [parse_qs(urlsplit(path).query)["session"][0] for path in server.paths]
    assert len(set(names)) == 2
    assert names[1] == names[2]
    async with client_of(server, session="mine"):
        assert "&session=mine&" in server.paths[-1]


async def test_the_client_resumes_its_session_with_its_frame_count(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        heard = await client.subscribe("chatter", String)
        call = asyncio.create_task(client.call("stop", Trigger, Empty()))
        [frame] = await server.heard("call_service")
        for word in ("one", "two"):
            await server.say(op="publish", topic="chatter", msg={"data": word})
            assert (await anext(heard)).data == word
        await reconnect(server, session_headers("resumed", taken=2))
        await server.say(
            op="service_response", service="stop", id=frame["id"], values={"success": True, "message": "!"}, result=True
        )
        assert await call == TriggerResponse(True, "!")
        await reconnect(server, session_headers("resumed", taken=2))
        assert resumption_points(server) == ["none", "s1.2", "s1.3"]
        await client.publish("chatter", String("here"))
        await server.heard("publish")
        assert len(server.of("subscribe")) == 1, "the cloud knows what it subscribed"
        assert (client.connections, client.resumptions) == (3, 2)


async def test_frames_not_received_by_the_cloud_are_resent_once(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        for number in range(4):
            await client.publish("chatter", String(str(number)))
        await server.heard("publish", 4)
        await reconnect(server, session_headers("resumed", taken=2))
        await client.publish("chatter", String("new"))
        await server.heard("publish", 7)
        await reconnect(server, session_headers("resumed", taken=5))
        await client.publish("chatter", String("last"))
        await server.heard("publish", 8)
    assert [frame["msg"]["data"] for frame in server.of("publish")] == ["0", "1", "2", "3", "2", "3", "new", "last"]


async def test_subscription_changes_while_disconnected_reach_the_session(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        old = await client.subscribe("old", String)
        await server.heard("subscribe")
        server.refusal = (503, b"")
        server.connections[-1].transport.abort()
        await until(lambda: not client.connected)
        await client.unsubscribe(old)
        await client.subscribe("new", String)
        server.refusal, server.headers = None, session_headers("resumed", taken=1)
        await server.heard("subscribe", 2)
    assert [frame["topic"] for frame in server.frames] == ["old", "old", "new"]
    assert len(server.of("unsubscribe")) == 1


async def test_a_lost_session_resubscribes_and_fails_pending_calls(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        await client.subscribe("chatter", String)
        await client.publish("chatter", String("sent"))
        call = asyncio.create_task(client.call("stop", Trigger, Empty()))
        await server.heard("call_service")
        await reconnect(server, session_headers("new", "s2"))
        with pytest.raises(Unavailable, match="was lost during the call of 'stop'"):
            await call
        await server.heard("subscribe", 2)
        await client.publish("chatter", String("after"))
        await server.heard("publish", 2)
        assert [frame["msg"]["data"] for frame in server.of("publish")] == ["sent", "after"]
        await reconnect(server, session_headers("resumed", "s2", taken=2))
        assert resumption_points(server) == ["none", "s1.0", "s2.0"]
        await until(lambda: client.resumptions == 1)


async def test_a_call_made_while_disconnected_is_sent_in_a_new_session(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        server.refusal = (503, b"")
        server.connections[-1].transport.abort()
        await until(lambda: not client.connected)
        call = asyncio.create_task(client.call("stop", Trigger, Empty()))
        await asyncio.sleep(0)
        server.refusal, server.headers = None, session_headers("new", "s2")
        [frame] = await server.heard("call_service")
        await server.say(
            op="service_response", service="stop", id=frame["id"], values={"success": True, "message": ""}, result=True
        )
        assert await call == TriggerResponse(True, "")


async def test_closing_the_client_states_that_it_left(server: RosbridgeServer) -> None:
    async with client_of(server):
        pass
    await server.connections[-1].wait_closed()
    assert (server.connections[-1].close_code, server.connections[-1].close_reason) == (1000, LEFT)


async def test_a_takeover_by_another_connection_closes_the_client(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        await server.connections[-1].close(4409, "conflict: another connection of the same session took over")
        with pytest.raises(Conflict, match="took over"):
            await asyncio.wait_for(client.closed(), 5)


async def test_an_idle_client_reconnects_when_it_publishes(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        await client.subscribe("chatter", String)
        await server.heard("subscribe")
        server.headers = session_headers("new", "s2")
        await server.connections[-1].close(1011, "idle: no frames for 600 s")
        await until(lambda: not client.connected)
        attempts = len(server.paths)
        await asyncio.sleep(0.1)  # ten times what it waits before it tries again
        assert len(server.paths) == attempts
        await client.publish("chatter", String("something"))
        await server.heard("publish")
        assert len(server.of("subscribe")) == 2


async def test_a_non_holding_operator_reconnects_after_an_idle_close(server: RosbridgeServer) -> None:
    async with client_of(server, role="operator", hold=False) as client:
        assert "&hold=0&" in server.paths[-1]
        await server.connections[-1].close(1011, "idle: no frames for 600 s")
        await until(lambda: client.connections == 2)


@pytest.fixture
async def nearer() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        running.headers = session_headers("resumed")
        yield running


@pytest.mark.parametrize("status", [401, 404, 503])
async def test_the_client_goes_to_the_endpoint_that_it_was_told_and_back(
    server: RosbridgeServer, nearer: RosbridgeServer, status: int
) -> None:
    server.headers |= {ENDPOINT_HEADER: nearer.url}
    async with client_of(server) as client:
        assert len(server.connections) == 1
        server.connections[-1].transport.abort()
        await nearer.connected(1)
        await until(lambda: client.resumptions == 1)
        assert resumption_points(nearer) == ["s1.0"], "it resumes the session there"
        nearer.refusal = (status, b"")
        nearer.connections[-1].transport.abort()
        await server.connected(2)
        await until(lambda: client.connections == 3)


@pytest.mark.parametrize("told", ["http://127.0.0.1:1", "gopher://hall", "http://127.0.0.1:99999"])
async def test_an_unusable_nearer_endpoint_does_not_keep_the_client_from_its_cloud(
    server: RosbridgeServer, told: str
) -> None:
    server.headers |= {ENDPOINT_HEADER: told}
    async with client_of(server) as client:
        await reconnect(server, session_headers("resumed") | {ENDPOINT_HEADER: told})
        await until(lambda: client.resumptions == 1)


def test_a_nearer_endpoint_without_tls_is_not_taken_in_place_of_one_with_it() -> None:
    secure = Address("https://cloud.example", robot="tb1", token="t", role="robot", session="s")
    secure.prefer("http://hall.example:8500")
    assert secure.at(None).startswith("wss://cloud.example/")
    secure.prefer("https://hall.example:8500/ppaas")
    assert secure.at(None).startswith("wss://hall.example:8500/ppaas/?")
    assert secure.go_back()
    assert secure.at(None).startswith("wss://cloud.example/")
    assert not secure.go_back()


def test_a_message_reaches_all_subscriptions_also_if_one_fails() -> None:
    def fail(_: Message) -> None:
        raise RuntimeError("the robot's program")

    registry, heard = SubscriptionRegistry(), list[Float64]()
    registry.add(TopicSubscription("/number", String, lambda _: None))
    registry.add(TopicSubscription("/number", Float64, fail))
    registry.add(TopicSubscription("number", Float64, heard.append))
    with pytest.raises(RuntimeError, match="the robot's program"):
        registry.deliver("number", msgspec.Raw(b'{"data": 1.0}'))
    assert heard == [Float64(1.0)]
