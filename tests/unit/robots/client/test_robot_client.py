"""The client against a real WebSocket server."""

import asyncio
import itertools
import json
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest

from ppaas.clock import monotonic
from ppaas.errors import (
    Conflict,
    InvalidInput,
    MessageTooLarge,
    NotAuthenticated,
    NotFound,
    NotPermitted,
    PPaaSError,
    QuotaExceeded,
    Unavailable,
)
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import String
from ppaas.messages.geometry_msgs import Twist, Vector3
from ppaas.messages.std_srvs import EmptyService, Trigger, TriggerResponse
from robots.client import connection_keeper
from robots.client.connection import ConnectionOptions
from robots.client.robot_client import RobotClient
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server
from tests.support.waiting import until


def at_once() -> Iterator[float]:
    return itertools.repeat(0.01)


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        yield running


def client_of(server: RosbridgeServer, **options: Any) -> RobotClient:
    return RobotClient(server.url, robot="tb 1", token="t&k", **{"reconnect_delays": at_once, **options})


async def test_the_client_sends_robot_token_role_and_status_level(server: RosbridgeServer) -> None:
    async with client_of(server, role="operator"):
        [path] = server.paths
        assert path.startswith("/?robot=tb+1&role=operator&status=1&session=")
        assert path.endswith("&resume=none")
        assert [sent["Authorization"] for sent in server.received] == ["Bearer t&k"]


async def test_the_path_of_the_url_is_kept(server: RosbridgeServer) -> None:
    for path in ("/ppaas", "/ppaas/", "/a/b"):
        async with RobotClient(server.url + path, robot="tb1", token="t", reconnect_delays=at_once):
            assert server.paths[-1].startswith(f"{path.rstrip('/')}/?robot=tb1&")


async def test_a_redirect_is_reported_instead_of_followed(server: RosbridgeServer) -> None:
    server.refusal = (301, b"")
    server.headers["Location"] = "https://elsewhere/?robot=tb1"
    with pytest.raises(InvalidInput, match=r"redirects to 'https://elsewhere/': give the URL"):
        async with client_of(server):
            pytest.fail("connected")
    assert len(server.paths) == 1


async def test_messages_are_published_in_order(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        for number in range(5):
            await client.publish("chatter", String(str(number)))
        frames = await server.heard("publish", 5)
    assert [frame["msg"]["data"] for frame in frames] == list("01234")
    assert {frame["topic"] for frame in frames} == {"chatter"}


async def test_messages_published_before_closing_are_sent(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        await client.publish("chatter", String("last words"))
    assert [frame["msg"]["data"] for frame in await server.heard("publish")] == ["last words"]


async def test_a_callback_receives_only_its_topic(server: RosbridgeServer) -> None:
    heard: asyncio.Queue[Twist] = asyncio.Queue()
    async with client_of(server) as client:
        await client.subscribe("cmd_vel", Twist, heard.put_nowait)
        [frame] = await server.heard("subscribe")
        assert (frame["topic"], frame["type"]) == ("cmd_vel", "geometry_msgs/Twist")
        await server.say(op="publish", topic="odom", msg={"linear": {"x": 9.0}})
        await server.say(op="publish", topic="/cmd_vel", msg={"linear": {"x": 0.25}})
        assert (await asyncio.wait_for(heard.get(), 5)).linear == Vector3(x=0.25)
        assert heard.empty()


async def test_a_queue_of_size_1_keeps_the_newest_message(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        newest = await client.subscribe("chatter", String, queue_size=1)
        everything = await client.subscribe("chatter", String)
        await server.heard("subscribe", 2)
        for number in range(4):
            await server.say(op="publish", topic="chatter", msg={"data": str(number)})
        assert [(await anext(everything)).data for _ in range(4)] == list("0123")
        assert (await anext(newest)).data == "3"
        assert newest.dropped == 3


async def test_the_last_unsubscription_of_a_topic_is_sent_to_the_server(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        first = await client.subscribe("chatter", String)
        second = await client.subscribe("/chatter", String)
        await client.unsubscribe(first)
        await client.unsubscribe(second)
        await server.heard("unsubscribe")
        assert len(server.of("unsubscribe")) == 1
        assert [message async for message in first] == []


async def test_an_invalid_message_is_skipped_and_the_next_is_delivered(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        subscription = await client.subscribe("chatter", String)
        await server.heard("subscribe")
        await server.connections[-1].send("no JSON at all")
        await server.say(op="publish", topic="chatter", msg={"data": 5})
        await server.say(op="publish", topic="chatter", msg={"data": "fine"})
        assert (await asyncio.wait_for(anext(subscription), 5)).data == "fine"


async def test_a_failing_callback_closes_the_client_with_the_reason(server: RosbridgeServer) -> None:
    def fail(_: String) -> None:
        raise ZeroDivisionError("error in the callback")

    async with client_of(server) as client:
        await client.subscribe("chatter", String, fail)
        await server.heard("subscribe")
        await server.say(op="publish", topic="chatter", msg={"data": "x"})
        with pytest.raises(PPaaSError, match="error in the callback"):
            await asyncio.wait_for(client.closed(), 5)
        with pytest.raises(PPaaSError, match="error in the callback"):
            await client.publish("chatter", String("y"))


# -- services ----------------------------------------------------------------------------------------------------------


async def test_concurrent_calls_get_their_own_responses(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        calls = [asyncio.create_task(client.call("stop", Trigger, Empty())) for _ in range(2)]
        frames = await server.heard("call_service", 2)
        for number, frame in reversed(list(enumerate(frames))):
            values = {"success": True, "message": str(number)}
            await server.say(op="service_response", service="stop", id=frame["id"], values=values, result=True)
        answers = await asyncio.gather(*calls)
    assert answers == [TriggerResponse(True, "0"), TriggerResponse(True, "1")]


async def test_a_failed_call_raises_the_error_of_the_service(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        call = asyncio.create_task(client.call("stop", EmptyService, Empty()))
        [frame] = await server.heard("call_service")
        await server.say(
            op="service_response", service="stop", id=frame["id"], values="not-found: unknown thing", result=False
        )
        with pytest.raises(NotFound, match="unknown thing"):
            await call


async def test_a_call_times_out_and_its_late_response_is_ignored(
    server: RosbridgeServer,
) -> None:
    async with client_of(server) as client:
        with pytest.raises(Unavailable, match=r"did not answer within 0\.05 s"):
            await client.call("stop", EmptyService, Empty(), timeout=0.05)
        [frame] = await server.heard("call_service")
        await server.say(op="service_response", service="stop", id=frame["id"], values={}, result=True)
        await client.publish("chatter", String("still here"))
        await server.heard("publish")


async def test_a_lost_connection_fails_pending_calls(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        call = asyncio.create_task(client.call("stop", EmptyService, Empty()))
        await server.heard("call_service")
        server.connections[-1].transport.abort()
        with pytest.raises(Unavailable, match="was lost during the call of 'stop'"):
            await asyncio.wait_for(call, 5)


async def test_status_errors_of_the_cloud_reach_the_callback(server: RosbridgeServer) -> None:
    errors: asyncio.Queue[PPaaSError] = asyncio.Queue()
    async with client_of(server, on_status=errors.put_nowait):
        await server.connected()
        await server.say(op="status", level="error", msg="not-permitted: an operator publishes no scan")
        error = await asyncio.wait_for(errors.get(), 5)
    assert isinstance(error, NotPermitted)
    assert str(error) == "an operator publishes no scan"


# -- lost connections --------------------------------------------------------------------------------------------------


async def test_reconnecting_resubscribes_and_sends_queued_messages(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        subscription = await client.subscribe("chatter", String)
        await server.heard("subscribe")
        server.refusal = (503, b"")
        server.connections[-1].transport.abort()
        await until(lambda: not client.connected)
        await client.publish("chatter", String("published while disconnected"))
        server.refusal = None
        await server.connected(2)
        assert len(await server.heard("subscribe", 2)) == 2
        assert "published while disconnected" in [frame["msg"]["data"] for frame in await server.heard("publish")]
        await server.say(op="publish", topic="chatter", msg={"data": "welcome back"})
        assert (await asyncio.wait_for(anext(subscription), 5)).data == "welcome back"
        assert client.connections == 2


async def test_a_topic_subscribed_while_disconnected_is_subscribed_once(
    server: RosbridgeServer,
) -> None:
    async with client_of(server) as client:
        server.refusal = (503, b"")
        server.connections[-1].transport.abort()
        await until(lambda: not client.connected)
        await client.subscribe("chatter", String)
        server.refusal = None
        await client.publish("chatter", String("after"))
        await server.heard("publish")
    assert len(server.of("subscribe")) == 1


async def test_the_client_reconnects_to_a_restarted_cloud(server: RosbridgeServer) -> None:
    async with client_of(server) as client:
        await server.connections[-1].close(1012, "restarting")
        await server.connected(2)
        await client.publish("chatter", String("hello again"))
        await server.heard("publish")


async def test_reconnecting_retries_while_the_old_connection_is_open(
    server: RosbridgeServer,
) -> None:
    async with client_of(server) as client:
        server.refusal = (409, b'{"type": "urn:ppaas:problem:conflict", "detail": "connected already"}')
        server.connections[-1].transport.abort()
        attempts = len(server.paths)
        await until(lambda: len(server.paths) >= attempts + 3)
        server.refusal = None
        await server.connected(2)
        await client.publish("chatter", String("mine again"))
        await server.heard("publish")


@pytest.mark.parametrize(
    ("code", "reason", "error"),
    [
        (4401, "the token has expired", NotAuthenticated),
        (4403, "", NotPermitted),
        (4429, "quota-exceeded: too much", QuotaExceeded),
        (1008, "", NotPermitted),
        (1009, "over 1 MiB", MessageTooLarge),
        (1011, "not-found: robot 'x' was removed", NotFound),
        (4409, "another connection took over", Conflict),
    ],
)
async def test_a_permanent_close_ends_readers_calls_and_publishers(
    server: RosbridgeServer, code: int, reason: str, error: type[PPaaSError]
) -> None:
    async with client_of(server) as client:
        subscription = await client.subscribe("chatter", String)
        call = asyncio.create_task(client.call("stop", EmptyService, Empty()))
        await server.heard("call_service")
        await server.connections[-1].close(code, reason)
        with pytest.raises(error, match=reason.rpartition(": ")[2] or None):
            await asyncio.wait_for(client.closed(), 5)
        with pytest.raises(error):
            await anext(subscription)
        with pytest.raises((error, Unavailable)):
            await call
        with pytest.raises(error):
            await client.publish("chatter", String("x"))
    assert len(server.connections) == 1


# -- refusals ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("status", "problem", "error"),
    [
        (401, {}, NotAuthenticated),
        (403, {}, NotPermitted),
        (404, {"type": "urn:ppaas:problem:not-found", "detail": "unknown robot 'tb 1'"}, NotFound),
        (409, {"type": "urn:ppaas:problem:conflict", "detail": "connected already"}, Conflict),
        (429, {"detail": "four robots a user"}, QuotaExceeded),
    ],
)
async def test_a_refused_handshake_raises_its_error_without_a_retry(
    server: RosbridgeServer, status: int, problem: dict[str, str], error: type[PPaaSError]
) -> None:
    server.refusal = (status, json.dumps(problem).encode())
    with pytest.raises(error, match=problem.get("detail")):
        async with client_of(server):
            pytest.fail("connected")
    assert len(server.paths) == 1


async def test_an_unavailable_cloud_is_retried(server: RosbridgeServer) -> None:
    server.refusal = (503, b'{"type": "urn:ppaas:problem:unavailable", "detail": "no room"}')
    entering = asyncio.create_task(client_of(server).__aenter__())
    await until(lambda: len(server.paths) >= 3)
    server.refusal = None
    client = await asyncio.wait_for(entering, 5)
    await client.__aexit__(None, None, None)


async def test_an_unreachable_cloud_raises_unavailable_after_the_timeout(server: RosbridgeServer) -> None:
    server.refusal = (503, b"")
    with pytest.raises(Unavailable, match="check that it runs"):
        async with client_of(server, connect_timeout=0.1):
            pytest.fail("connected")


STARTING = (503, b'{"type": "urn:ppaas:problem:starting", "detail": "compiling kernels, 12 of 107"}')


async def test_a_cloud_that_is_starting_is_waited_for_beyond_the_timeout(
    server: RosbridgeServer, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(connection_keeper, "STARTING_DELAY", 0.05)
    server.refusal = STARTING
    entering = asyncio.create_task(client_of(server, connect_timeout=2.0).__aenter__())
    began = monotonic()
    await until(lambda: monotonic() - began > 2.5 or entering.done())
    assert not entering.done()
    assert caplog.text.count("12 of 107") == 1
    server.refusal = None
    client = await asyncio.wait_for(entering, 10)
    await client.__aexit__(None, None, None)


async def test_the_timeout_says_that_the_cloud_was_starting(
    server: RosbridgeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection_keeper, "STARTING_DELAY", 600.0)
    server.refusal = STARTING
    with pytest.raises(Unavailable, match="compiling kernels, 12 of 107"):
        async with client_of(server, connect_timeout=0.2):
            pytest.fail("connected")


@pytest.mark.parametrize("url", ["cloud:8080", "ftp://cloud", "http://", ""])
async def test_an_invalid_url_is_refused(url: str) -> None:
    with pytest.raises(InvalidInput, match="http://host:port"):
        RobotClient(url, robot="tb1", token="t")


# -- slow links --------------------------------------------------------------------------------------------------------


async def test_a_slow_link_drops_only_old_scans() -> None:
    small = ConnectionOptions(write_limit=1024)
    async with rosbridge_server(max_queue=1) as server, client_of(server, link=small, capacity=8) as client:
        server.listening.clear()
        commands = 40
        filler = "x" * 500_000

        async def publish_all() -> None:
            for number in range(commands):
                await client.publish("scan", String(f"{number}:{filler}"), newest_only=True)
                await client.publish("command", String(f"{number}:{filler}"))

        publishing = asyncio.create_task(publish_all())
        await until(lambda: client.dropped)
        assert not publishing.done(), "publishing without loss waits"
        server.listening.set()
        await asyncio.wait_for(publishing, 30)
        await client.publish("command", String("end"))
        await until(lambda: any(frame["msg"]["data"] == "end" for frame in server.of("publish")))
        numbers = {
            topic: [int(f["msg"]["data"].partition(":")[0]) for f in server.of("publish")[:-1] if f["topic"] == topic]
            for topic in ("scan", "command")
        }
        assert numbers["command"] == list(range(commands))
        assert numbers["scan"] == sorted(set(numbers["scan"]))
        assert len(numbers["scan"]) == commands - client.dropped
