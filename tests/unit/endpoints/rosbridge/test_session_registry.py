"""Sessions that outlive their sockets, over real sockets, with a container played by the test."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from endpoints import rosbridge
from endpoints.rosbridge import TAKEN_OVER
from engine.protocols import robot_link
from engine.sessions import host
from ppaas.errors import Unavailable
from ppaas.wire.resumption import LEFT, STATE_HEADER
from tests.support.endpoints.robot_world import KEY, World, closed, hear, next_of, refusal, say, session_headers
from tests.support.engine.played_container import PlayedContainer
from tests.support.waiting import until

LONG = 1000.0


@pytest.fixture
async def world(world: World) -> World:
    """Retain detached sessions for the duration of a test."""
    world.linger(LONG)
    return world


@asynccontextmanager
async def robot(world: World, **query: str) -> AsyncIterator[tuple[ClientConnection, PlayedContainer]]:
    """Connect a robot with a session; at the end no session is retained."""
    async with world.robot(session="mine", **query) as (client, container):
        yield client, container
        world.linger(0.0)
    await world.service.close_place(KEY, Unavailable("the test is over"))


async def cut_off(world: World, client: ClientConnection) -> None:
    client.transport.abort()
    await until(lambda: world.machine.away)


async def publish(container: PlayedContainer, topic: str, **message: Any) -> None:
    container.stream.write(robot_link.Published(topic, json.dumps(message).encode()))


async def test_a_resumed_session_keeps_subscriptions_and_status_level(world: World) -> None:
    async with robot(world, status="1") as (first, container):
        assert session_headers(first)[0] == "new"
        await say(first, op="subscribe", topic="/goal", id="s1", queue_length=2)
        assert (await next_of(container, robot_link.SubscribeTopic)).topic == "goal"
        await cut_off(world, first)
        for number in range(5):
            await publish(container, "goal", data=str(number))
        async with world.connected(session="mine") as again:
            assert session_headers(again)[:2] == ("resumed", session_headers(first)[1])
            assert [(await hear(again))["msg"]["data"] for _ in range(2)] == ["3", "4"], "as many as its queue_length"
            await publish(container, "goal", data="now")
            assert (await hear(again))["msg"]["data"] == "now"
            await again.send("{")
            assert (await hear(again))["op"] == "status", "its status level was kept"


async def test_an_answer_waits_for_the_client_to_reconnect(world: World) -> None:
    async with robot(world) as (first, container):
        await say(first, op="call_service", service="/make_plan", id="7", args={})
        call = await next_of(container, robot_link.ServiceCall)
        await cut_off(world, first)
        container.stream.write(robot_link.ServiceAnswer(call.call, b'{"plan":1}'))
        async with world.connected(session="mine") as again:
            answer = await hear(again)
            assert (answer["id"], answer["values"]) == ("7", {"plan": 1})


async def test_an_expired_command_is_not_sent_after_a_reconnect(world: World) -> None:
    async with robot(world) as (first, container):
        await say(first, op="subscribe", topic="/cmd_vel")
        await next_of(container, robot_link.SubscribeTopic)
        await cut_off(world, first)
        await publish(container, "cmd_vel", linear={"x": 1.0})
        (retained,) = container.host._named.values()
        outbox = retained.session.outbox
        await until(lambda: len(outbox))
        outbox._clock = lambda: float("inf")
        async with world.connected(session="mine") as again:
            await until(lambda: not len(outbox))
            outbox._clock = lambda: 0.0
            await publish(container, "cmd_vel", linear={"x": 2.0})
            assert (await hear(again))["msg"]["linear"]["x"] == 2.0


async def test_a_connection_without_a_session_name_is_not_retained(world: World) -> None:
    async with robot(world), world.connected("operator") as first:
        assert first.response is not None
        assert STATE_HEADER not in first.response.headers
        first.transport.abort()
        await until(lambda: len(list(world.clients.attachments())) == 1)
        assert world.machine.away == 0


async def test_sessions_differ_by_name_and_role(world: World) -> None:
    async with (
        robot(world) as (first, _),
        world.connected("operator", session="mine") as operator,
        world.connected("operator", session="other") as other,
    ):
        ids = {session_headers(client)[1] for client in (first, operator, other)}
        assert len(ids) == 3


# -- taking over -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("role", ["robot", "operator"])
async def test_the_same_session_takes_over_from_an_open_socket(world: World, role: str) -> None:
    async with robot(world) as (first, _), world.connected("operator", session="mine") as operator:
        old = first if role == "robot" else operator
        async with world.connected(role, session="mine") as new:
            assert session_headers(new)[:2] == ("resumed", session_headers(old)[1])
            assert await closed(old) == (TAKEN_OVER, "conflict: another connection of the same session took over")


async def test_a_responsive_robot_is_not_replaced_by_another_session(world: World) -> None:
    async with robot(world) as (first, container):
        status, problem = await refusal(world.url(session="other"))
        assert (status, problem["type"]) == (409, "urn:ppaas:problem:conflict")
        await say(first, op="publish", topic="/goal", msg={"data": "x"})
        assert (await next_of(container, robot_link.Deliver)).topic == "goal"


async def test_a_robot_without_a_session_replaces_an_unresponsive_one(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(rosbridge, "PROBE_TIMEOUT", 0.2)
    async with robot(world) as (first, container):
        first.transport.pause_reading()  # the connection stays open, and nothing reads from it
        async with world.connected() as second:
            await say(second, op="publish", topic="/goal", msg={"data": "x"})
            assert (await next_of(container, robot_link.Deliver)).topic == "goal"
            first.transport.resume_reading()
            assert (await closed(first))[0] == TAKEN_OVER


async def test_one_of_many_concurrent_takeovers_remains(world: World) -> None:
    async with robot(world):
        opened = await asyncio.gather(
            *(connect(world.url("operator", session="many"), open_timeout=10) for _ in range(5))
        )
        await until(lambda: [one.request.role for one in world.clients.attachments()].count("operator") == 1)
        assert sum(session_headers(client)[0] == "new" for client in opened) == 1
        for client in opened:
            await client.close()


# -- nothing lost, nothing twice ---------------------------------------------------------------------------------------


async def test_resuming_resends_lasting_frames_and_reports_those_received(world: World) -> None:
    async with robot(world, resume="none") as (first, container):
        await say(first, op="subscribe", topic="/goal")
        await next_of(container, robot_link.SubscribeTopic)
        await say(first, op="call_service", service="/make_plan", id="1", args={})
        call = await next_of(container, robot_link.ServiceCall)
        await publish(container, "goal", data="heard")
        container.stream.write(robot_link.ServiceAnswer(call.call, b"{}"))
        assert [(await hear(first))["op"] for _ in range(2)] == ["publish", "service_response"]
        await cut_off(world, first)
        session = session_headers(first)[1]
        async with world.connected(session="mine", resume=f"{session}.1") as again:
            assert session_headers(again) == ("resumed", session, 2)
            assert (await hear(again))["id"] == "1"
            again.transport.abort()
            await until(lambda: world.machine.away)
        async with world.connected(session="mine", resume=f"{session}.2") as third:
            assert session_headers(third) == ("resumed", session, 2)
            await publish(container, "goal", data="next")
            assert (await hear(third))["msg"] == {"data": "next"}, "the answer was received, and is not repeated"


@pytest.mark.parametrize("resume", ["none", "0123456789abcdef.5"])
async def test_an_unknown_session_id_starts_a_new_session(world: World, resume: str) -> None:
    async with robot(world, resume="none") as (first, container):
        await say(first, op="subscribe", topic="/goal")
        await next_of(container, robot_link.SubscribeTopic)
        await cut_off(world, first)
        async with world.connected(session="mine", resume=resume) as again:
            state, session, taken = session_headers(again)
            assert (state, taken) == ("new", 0)
            assert session != session_headers(first)[1]
            assert (await next_of(container, robot_link.UnsubscribeTopic)).topic == "goal"


# -- the end of a session ----------------------------------------------------------------------------------------------


async def test_a_session_is_retained_no_longer_than_the_linger(world: World) -> None:
    async with robot(world) as (_, container):
        world.clients._linger = 0.01
        async with world.connected("operator", session="theirs") as operator:
            await say(operator, op="subscribe", topic="/goal")
            await next_of(container, robot_link.SubscribeTopic)
            operator.transport.abort()
            assert (await next_of(container, robot_link.UnsubscribeTopic)).topic == "goal"
        assert world.machine.away == 0


async def test_a_client_that_states_it_left_is_not_retained(world: World) -> None:
    async with robot(world) as (_, container), world.connected("operator", session="theirs") as operator:
        await say(operator, op="subscribe", topic="/goal")
        await next_of(container, robot_link.SubscribeTopic)
        await operator.close(reason=LEFT)
        assert (await next_of(container, robot_link.UnsubscribeTopic)).topic == "goal"
        assert world.machine.away == 0


async def test_the_oldest_detached_session_ends_if_there_are_too_many(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(host, "MAX_AWAY", 2)
    async with robot(world):
        for number in range(4):
            async with world.connected("operator", session=f"s{number}") as operator:
                operator.transport.abort()
            await until(
                lambda n=number: len(list(world.clients.attachments())) == 1 and world.machine.away == min(n + 1, 2)
            )
        assert [key.name for key in world.machine.containers[0].host._named if key.role == "operator"] == ["s2", "s3"]


async def test_a_detached_session_ends_with_its_place(world: World) -> None:
    async with robot(world) as (first, _):
        await cut_off(world, first)
        await world.service.close_place(KEY, Unavailable("over"))
        await until(lambda: world.machine.away == 0)


async def test_reconnecting_to_another_place_starts_a_new_session(world: World) -> None:
    async with robot(world) as (first, _):
        await world.service.close_place(KEY, Unavailable("over"))
        assert (await closed(first))[1] == "unavailable: over"
        connecting = asyncio.ensure_future(connect(world.url(session="mine"), open_timeout=10))
        while not hasattr(order := await world.machine.order(), "spec"):
            pass
        second = await world.machine.boot(order)  # type: ignore[arg-type]
        async with await connecting as again:
            assert session_headers(again)[0] == "new"
        await second.stream.close()


# -- operators that hold no place --------------------------------------------------------------------------------------


async def test_an_operator_that_holds_no_place_neither_opens_nor_keeps_one(world: World) -> None:
    status, problem = await refusal(world.url("operator", hold="0"))
    assert (status, problem["type"]) == (503, "urn:ppaas:problem:unavailable")
    assert "has no container now" in problem["detail"]
    assert not world.machine.has_orders()
    world.linger(0.0)
    async with world.robot() as (first, container), world.connected("operator", hold="0") as viewer:
        await say(viewer, op="subscribe", topic="/goal")
        await next_of(container, robot_link.SubscribeTopic)
        await publish(container, "goal", data="seen")
        assert (await hear(viewer))["msg"] == {"data": "seen"}
        await first.close()
        code, reason = await closed(viewer)
        assert code == 1011
        assert reason.startswith("unavailable: no client was connected")


@pytest.mark.parametrize(
    "query",
    [
        {"session": "a%20b"}, {"session": ""}, {"session": "x" * 65}, {"resume": "none"}, {"hold": "0"},
        {"hold": "yes"}, {"session": "a", "resume": "x"}, {"session": "a", "resume": "x.-1"},
        {"session": "a", "resume": "x." + "9" * 40},
    ],
    ids=str,
)  # fmt: skip
async def test_invalid_query_parameters_are_refused(world: World, query: dict[str, str]) -> None:
    status, problem = await refusal(world.url(**query))
    assert (status, problem["type"]) == (422, "urn:ppaas:problem:invalid-parameter")
