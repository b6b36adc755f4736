"""Sessions that outlive their sockets, over real sockets, with a container played by the test."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect

from endpoints.rosbridge import attachment, session_registry
from endpoints.rosbridge.robot_socket import TAKEN_OVER
from engine.protocols import robot_link
from ppaas.errors import Unavailable
from ppaas.wire.resumption import ID_HEADER, LEFT, STATE_HEADER, TAKEN_HEADER
from tests.support.endpoints.robot_world import KEY, World, closed, hear, next_of, refusal, say
from tests.support.engine.fake_machine import FarContainer
from tests.support.waiting import until

LONG = 1000.0


@pytest.fixture
async def world(world: World) -> World:
    """Retain detached sessions for the duration of a test."""
    world.linger(LONG)
    return world


@asynccontextmanager
async def robot(world: World, **query: str) -> AsyncIterator[tuple[ClientConnection, FarContainer]]:
    """Connect a robot with a session; at the end no session is retained."""
    async with world.robot(session="mine", **query) as (client, container):
        yield client, container
        world.linger(0.0)
    world.clients.close()
    await world.service.close_place(KEY, Unavailable("the test is over"))


def told(client: ClientConnection) -> tuple[str, str, int]:
    """Return the session headers of the handshake: state, id, number of frames received."""
    assert client.response is not None
    headers = client.response.headers
    return headers[STATE_HEADER], headers[ID_HEADER], int(headers[TAKEN_HEADER])


async def cut_off(world: World, client: ClientConnection) -> None:
    client.transport.abort()
    await until(lambda: world.clients.away)


async def publish(container: FarContainer, topic: str, **message: Any) -> None:
    container.stream.write(robot_link.Published(topic, json.dumps(message).encode()))


async def test_a_client_that_comes_back_hears_what_it_heard_before(world: World) -> None:
    async with robot(world, status="1") as (first, container):
        assert told(first)[0] == "new"
        await say(first, op="subscribe", topic="/goal", id="s1", queue_length=2)
        assert (await next_of(container, robot_link.Subscribe)).topic == "goal"
        await cut_off(world, first)
        for number in range(5):
            await publish(container, "goal", data=str(number))
        async with world.connected(session="mine") as again:
            assert told(again)[:2] == ("resumed", told(first)[1])
            assert [(await hear(again))["msg"]["data"] for _ in range(2)] == ["3", "4"], "as many as it wanted to wait"
            await publish(container, "goal", data="now")
            assert (await hear(again))["msg"]["data"] == "now"
            await again.send("{")
            assert (await hear(again))["op"] == "status", "its status level was kept"


async def test_an_answer_to_a_call_waits_for_who_asked(world: World) -> None:
    async with robot(world) as (first, container):
        await say(first, op="call_service", service="/make_plan", id="7", args={})
        call = await next_of(container, robot_link.ServiceCall)
        await cut_off(world, first)
        container.stream.write(robot_link.ServiceAnswer(call.call, b'{"plan":1}'))
        async with world.connected(session="mine") as again:
            answer = await hear(again)
            assert (answer["id"], answer["values"]) == ("7", {"plan": 1})


async def test_an_old_command_is_not_told_to_who_comes_back(world: World) -> None:
    async with robot(world) as (first, container):
        await say(first, op="subscribe", topic="/cmd_vel")
        await next_of(container, robot_link.Subscribe)
        await cut_off(world, first)
        await publish(container, "cmd_vel", linear={"x": 1.0})
        (retained,) = world.clients._retained.values()
        outbox = retained.session.outbox
        await until(lambda: len(outbox))
        outbox._clock = lambda: float("inf")
        async with world.connected(session="mine") as again:
            await until(lambda: not len(outbox))
            outbox._clock = lambda: 0.0
            await publish(container, "cmd_vel", linear={"x": 2.0})
            assert (await hear(again))["msg"]["linear"]["x"] == 2.0


async def test_without_a_name_nothing_is_kept_and_nothing_is_told(world: World) -> None:
    async with robot(world), world.connected("operator") as first:
        assert first.response is not None
        assert STATE_HEADER not in first.response.headers
        first.transport.abort()
        await until(lambda: len(list(world.clients.attachments())) == 1)
        assert world.clients.away == 0


async def test_sessions_of_another_name_role_or_robot_are_others(world: World) -> None:
    async with (
        robot(world) as (first, _),
        world.connected("operator", session="mine") as operator,
        world.connected("operator", session="other") as other,
    ):
        ids = {told(client)[1] for client in (first, operator, other)}
        assert len(ids) == 3


# -- taking over -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("role", ["robot", "operator"])
async def test_the_same_session_takes_over_from_a_socket_that_still_stands(world: World, role: str) -> None:
    async with robot(world) as (first, _), world.connected("operator", session="mine") as operator:
        old = first if role == "robot" else operator
        async with world.connected(role, session="mine") as new:
            assert told(new)[:2] == ("resumed", told(old)[1])
            assert await closed(old) == (TAKEN_OVER, "conflict: another connection of the same session took over")


async def test_a_robot_that_answers_is_not_pushed_aside_by_another_session(world: World) -> None:
    async with robot(world) as (first, container):
        status, problem = await refusal(world.url(session="other"))
        assert (status, problem["type"]) == (409, "urn:ppaas:problem:conflict")
        await say(first, op="publish", topic="/goal", msg={"data": "x"})
        assert (await next_of(container, robot_link.Deliver)).topic == "goal"


async def test_a_robot_without_a_session_takes_over_from_one_that_is_silently_gone(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(attachment, "PROBE_TIMEOUT", 0.2)
    async with robot(world) as (first, container):
        first.transport.pause_reading()  # its end of the connection stands, and nobody is there
        async with world.connected() as second:
            await say(second, op="publish", topic="/goal", msg={"data": "x"})
            assert (await next_of(container, robot_link.Deliver)).topic == "goal"
            first.transport.resume_reading()
            assert (await closed(first))[0] == TAKEN_OVER


async def test_many_that_take_over_at_once_leave_one(world: World) -> None:
    async with robot(world):
        opened = await asyncio.gather(
            *(connect(world.url("operator", session="many"), open_timeout=10) for _ in range(5))
        )
        await until(lambda: [one.request.role for one in world.clients.attachments()].count("operator") == 1)
        assert sum(told(client)[0] == "new" for client in opened) == 1
        for client in opened:
            await client.close()


# -- nothing lost, nothing twice ---------------------------------------------------------------------------------------


async def test_a_client_that_counts_is_sent_again_what_lasts_and_told_what_arrived(world: World) -> None:
    async with robot(world, resume="none") as (first, container):
        await say(first, op="subscribe", topic="/goal")
        await next_of(container, robot_link.Subscribe)
        await say(first, op="call_service", service="/make_plan", id="1", args={})
        call = await next_of(container, robot_link.ServiceCall)
        await publish(container, "goal", data="heard")
        container.stream.write(robot_link.ServiceAnswer(call.call, b"{}"))
        assert [(await hear(first))["op"] for _ in range(2)] == ["publish", "service_response"]
        await cut_off(world, first)
        session = told(first)[1]
        async with world.connected(session="mine", resume=f"{session}.1") as again:
            assert told(again) == ("resumed", session, 2)
            assert (await hear(again))["id"] == "1"
            again.transport.abort()
            await until(lambda: world.clients.away)
        async with world.connected(session="mine", resume=f"{session}.2") as third:
            assert told(third) == ("resumed", session, 2)
            await publish(container, "goal", data="next")
            assert (await hear(third))["msg"] == {"data": "next"}, "the answer was received, and is not repeated"


@pytest.mark.parametrize("resume", ["none", "0123456789abcdef.5"])
async def test_who_knows_of_another_session_or_of_none_begins_anew(world: World, resume: str) -> None:
    async with robot(world, resume="none") as (first, container):
        await say(first, op="subscribe", topic="/goal")
        await next_of(container, robot_link.Subscribe)
        await cut_off(world, first)
        async with world.connected(session="mine", resume=resume) as again:
            state, session, taken = told(again)
            assert (state, taken) == ("new", 0)
            assert session != told(first)[1]
            assert (await next_of(container, robot_link.Unsubscribe)).topic == "goal"


# -- the end of a session ----------------------------------------------------------------------------------------------


async def test_a_session_is_kept_no_longer_than_the_linger(world: World) -> None:
    async with robot(world) as (_, container):
        world.clients._linger = 0.01
        async with world.connected("operator", session="theirs") as operator:
            await say(operator, op="subscribe", topic="/goal")
            await next_of(container, robot_link.Subscribe)
            operator.transport.abort()
            assert (await next_of(container, robot_link.Unsubscribe)).topic == "goal"
        assert world.clients.away == 0


async def test_who_says_that_it_left_is_not_kept(world: World) -> None:
    async with robot(world) as (_, container), world.connected("operator", session="theirs") as operator:
        await say(operator, op="subscribe", topic="/goal")
        await next_of(container, robot_link.Subscribe)
        await operator.close(reason=LEFT)
        assert (await next_of(container, robot_link.Unsubscribe)).topic == "goal"
        assert world.clients.away == 0


async def test_of_too_many_sessions_that_are_away_the_first_is_ended(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(session_registry, "MAX_AWAY", 2)
    async with robot(world):
        for number in range(4):
            async with world.connected("operator", session=f"s{number}") as operator:
                operator.transport.abort()
            await until(
                lambda n=number: len(list(world.clients.attachments())) == 1 and world.clients.away == min(n + 1, 2)
            )
        assert [key.name for key in world.clients._retained if key.role == "operator"] == ["s2", "s3"]


async def test_a_session_ends_with_its_place_though_its_client_is_away(world: World) -> None:
    async with robot(world) as (first, _):
        await cut_off(world, first)
        await world.service.close_place(KEY, Unavailable("over"))
        await until(lambda: world.clients.away == 0)


async def test_a_client_that_comes_back_to_another_place_begins_anew(world: World) -> None:
    async with robot(world) as (first, _):
        await world.service.close_place(KEY, Unavailable("over"))
        assert (await closed(first))[1] == "unavailable: over"
        connecting = asyncio.ensure_future(connect(world.url(session="mine"), open_timeout=10))
        while not hasattr(order := await world.machine.order(), "spec"):
            pass
        second = await world.machine.boot(order)  # type: ignore[arg-type]
        async with await connecting as again:
            assert told(again)[0] == "new"
        await second.stream.close()


# -- who does not hold a place -----------------------------------------------------------------------------------------


async def test_an_operator_that_holds_nothing_opens_nothing_and_keeps_nothing(world: World) -> None:
    status, problem = await refusal(world.url("operator", hold="0"))
    assert (status, problem["type"]) == (503, "urn:ppaas:problem:unavailable")
    assert "has no container now" in problem["detail"]
    assert not world.machine.has_orders()
    world.linger(0.0)
    async with world.robot() as (first, container), world.connected("operator", hold="0") as looker:
        await say(looker, op="subscribe", topic="/goal")
        await next_of(container, robot_link.Subscribe)
        await publish(container, "goal", data="seen")
        assert (await hear(looker))["msg"] == {"data": "seen"}
        await first.close()
        code, reason = await closed(looker)
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
async def test_what_cannot_be_in_an_address_is_told(world: World, query: dict[str, str]) -> None:
    status, problem = await refusal(world.url(**query))
    assert (status, problem["type"]) == (422, "urn:ppaas:problem:invalid-parameter")
