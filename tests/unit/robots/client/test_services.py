"""Services that a client advertises."""

import asyncio
import itertools
from collections.abc import AsyncIterator, Iterator
from typing import Any

import pytest

from ppaas.errors import Conflict, MalformedMessage, NotFound, Unavailable
from ppaas.messages import Message
from ppaas.messages.base.message import Empty
from ppaas.messages.base.std_msgs import String
from ppaas.messages.std_srvs import SetBool, SetBoolRequest, SetBoolResponse, Trigger, TriggerResponse
from ppaas.wire.resumption import ID_HEADER, STATE_HEADER, TAKEN_HEADER
from robots.client import services
from robots.client.robot_client import RobotClient
from tests.support.endpoints.rosbridge_server import RosbridgeServer, rosbridge_server


def at_once() -> Iterator[float]:
    return itertools.repeat(0.01)


@pytest.fixture
async def server() -> AsyncIterator[RosbridgeServer]:
    async with rosbridge_server() as running:
        yield running


@pytest.fixture
async def client(server: RosbridgeServer) -> AsyncIterator[RobotClient]:
    async with RobotClient(server.url, robot="tb1", token="t", reconnect_delays=at_once) as connected:
        yield connected


async def ask(server: RosbridgeServer, number: int, service: str = "lights", **more: Any) -> None:
    await server.say(op="call_service", service=service, id=str(number), **more)


async def answers(server: RosbridgeServer, count: int = 1) -> dict[str, Any]:
    """Return the responses by call id: the values, or the reason of a failure."""
    return {frame["id"]: frame["values"] for frame in await server.heard("service_response", count)}


def switch(request: SetBoolRequest) -> SetBoolResponse:
    return SetBoolResponse(True, "on" if request.data else "off")


async def test_an_advertised_service_answers_until_it_is_unadvertised(
    server: RosbridgeServer, client: RobotClient
) -> None:
    await client.advertise_service("/lights", SetBool, switch)
    assert await server.heard("advertise_service") == [
        {"op": "advertise_service", "service": "/lights", "type": "std_srvs/SetBool"}
    ]
    await ask(server, 1, "/lights", args={"data": True})
    assert await server.heard("service_response") == [
        {
            "op": "service_response",
            "service": "/lights",
            "id": "1",
            "result": True,
            "values": {"success": True, "message": "on"},
        }
    ]
    with pytest.raises(Conflict, match="already advertises service 'lights'"):
        await client.advertise_service("lights", SetBool, switch)
    await client.unadvertise_service("lights")
    assert [frame["service"] for frame in await server.heard("unadvertise_service")] == ["lights"]
    with pytest.raises(NotFound, match="unknown advertised service 'lights'"):
        await client.unadvertise_service("lights")
    await ask(server, 2, args={"data": True})
    assert (await answers(server, 2))["2"].startswith("unavailable: service 'lights' is no longer advertised")


async def test_an_invalid_service_name_is_not_advertised(server: RosbridgeServer, client: RobotClient) -> None:
    with pytest.raises(MalformedMessage):
        await client.advertise_service("a b", SetBool, switch)
    await client.publish("chatter", String("x"))
    await server.heard("publish")
    assert server.of("advertise_service") == []


async def test_calls_run_concurrently_and_do_not_block_subscriptions(
    server: RosbridgeServer, client: RobotClient
) -> None:
    switched_on = asyncio.Event()

    async def wait(request: SetBoolRequest) -> SetBoolResponse:
        if request.data:
            switched_on.set()
        await switched_on.wait()
        return SetBoolResponse(True, str(request.data))

    heard = await client.subscribe("chatter", String)
    await client.advertise_service("lights", SetBool, wait)
    await server.heard("advertise_service")
    await ask(server, 1, args={"data": False})
    await server.say(op="publish", topic="chatter", msg={"data": "meanwhile"})
    assert (await anext(heard)).data == "meanwhile"
    assert server.of("service_response") == []
    await ask(server, 2, args={"data": True})
    received = await answers(server, 2)
    assert {number: values["message"] for number, values in received.items()} == {"1": "False", "2": "True"}


@pytest.mark.parametrize(
    ("handler", "args", "reason"),
    [
        (switch, {"data": "yes"}, "malformed-message: "),
        (switch, 5, "malformed-message: "),
        (lambda _: _raise(Unavailable("no bulb")), {}, "unavailable: no bulb"),
        (
            lambda _: _raise(ZeroDivisionError("secret")),
            {},
            "error: the handler of service 'lights' failed: ZeroDivisionError",
        ),
        (lambda _: Empty(), {}, "error: the handler of service 'lights' must return SetBoolResponse, not Empty"),
        (lambda _: SetBoolResponse(object()), {}, "error: the handler of service 'lights' failed: TypeError"),  # type: ignore[arg-type]
    ],
)
async def test_a_failed_call_returns_a_reason(
    handler: services.Handler, args: Any, reason: str, server: RosbridgeServer, client: RobotClient
) -> None:
    await client.advertise_service("lights", SetBool, handler)
    await server.heard("advertise_service")
    await ask(server, 1, args=args)
    [response] = await server.heard("service_response")
    assert response["result"] is False
    assert response["values"].startswith(reason)
    assert "secret" not in response["values"]
    assert client.connected


def _raise(error: Exception) -> Message:
    raise error


async def test_calls_beyond_the_limit_are_refused(
    server: RosbridgeServer, client: RobotClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(services, "MAX_CALLS", 1)
    released = asyncio.Event()

    async def wait(_: Empty) -> TriggerResponse:
        await released.wait()
        return TriggerResponse(True, "done")

    await client.advertise_service("lights", Trigger, wait)
    await server.heard("advertise_service")
    await ask(server, 1)
    await ask(server, 2)
    assert (await answers(server))["2"].startswith("quota-exceeded: ")
    released.set()
    assert (await answers(server, 2))["1"]["message"] == "done"


async def test_a_new_session_readvertises_and_drops_calls_of_the_old_one(
    server: RosbridgeServer, client: RobotClient
) -> None:
    begun, ended = asyncio.Queue[str](), asyncio.Queue[str]()

    async def wait(request: SetBoolRequest) -> SetBoolResponse:
        if request.data:
            return SetBoolResponse(True, "new")
        begun.put_nowait("old")
        try:
            await asyncio.Event().wait()
        finally:
            ended.put_nowait("old")
        return SetBoolResponse(True, "old")

    await client.advertise_service("lights", SetBool, wait)
    await client.advertise_service("horn", SetBool, wait)
    await client.unadvertise_service("horn")
    await server.heard("unadvertise_service")
    await ask(server, 1)
    await begun.get()
    server.connections[-1].transport.abort()
    await server.connected(2)
    assert [frame["service"] for frame in await server.heard("advertise_service", 3)] == ["lights", "horn", "lights"]
    assert await ended.get() == "old"
    await ask(server, 1, args={"data": True})
    assert (await answers(server))["1"]["message"] == "new"


async def test_a_resumed_session_sends_the_answer_on_its_next_connection(server: RosbridgeServer) -> None:
    begun, released = asyncio.Event(), asyncio.Event()

    async def wait(_: Empty) -> TriggerResponse:
        begun.set()
        await released.wait()
        return TriggerResponse(True, "late")

    server.headers = {STATE_HEADER: "new", ID_HEADER: "s1", TAKEN_HEADER: "0"}
    async with RobotClient(server.url, robot="tb1", token="t", reconnect_delays=at_once) as client:
        await client.advertise_service("lights", Trigger, wait)
        await server.heard("advertise_service")
        await ask(server, 1)
        await begun.wait()
        server.headers = {STATE_HEADER: "resumed", ID_HEADER: "s1", TAKEN_HEADER: "1"}
        server.connections[-1].transport.abort()
        await server.connected(2)
        released.set()
        assert (await answers(server))["1"]["message"] == "late"
        assert len(server.of("advertise_service")) == 1
