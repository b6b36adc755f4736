"""Robot WebSocket over a real server, with a machine and containers played by the test."""

import asyncio
import json
import logging
from typing import Any

import pytest
from starlette.datastructures import QueryParams
from starlette.websockets import WebSocket
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus
from websockets.typing import Origin

from endpoints import rosbridge
from endpoints.http.websocket_protocol import MAX_REASON
from endpoints.rosbridge import LONGEST_SOFTWARE, MAX_LISTED, content_of, parse_connect_request, reads_png, software_of
from engine.protocols import control_link, robot_link
from engine.protocols.control_link import StopContainer
from engine.protocols.refusals import Refusal
from engine.sessions import session
from engine.sessions.calls import MAX_CALLS
from engine.sessions.outbox import FrameOutbox
from engine.sessions.session import MAX_LOGGED
from ppaas.errors import InvalidParameter, NotFound, Unavailable
from ppaas.wire.rosbridge import RosbridgeSession
from storage.records import Limits, User
from tests.support.endpoints.robot_world import KEY, PASSWORD, World, closed, hear, next_of, refusal, say
from tests.support.storage import records
from tests.support.waiting import until

# -- before the handshake is done --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("query", "status", "slug"),
    [
        ({"role": "king"}, 422, "invalid-parameter"),
        ({"robot": ""}, 422, "invalid-parameter"),
        ({"token": ""}, 401, "not-authenticated"),
        ({"token": "wrong"}, 401, "not-authenticated"),
        ({"robot": "nobody"}, 404, "not-found"),
        ({"robot": "..%2Fbob"}, 400, "invalid-input"),
    ],
    ids=["role", "no robot", "no token", "wrong token", "unknown robot", "odd robot"],
)
async def test_invalid_requests_are_refused_before_the_handshake(
    world: World, query: dict[str, str], status: int, slug: str
) -> None:
    got, problem = await refusal(world.url(**query))
    assert (got, problem["type"]) == (status, f"urn:ppaas:problem:{slug}")
    assert not world.machine.has_orders()


async def test_the_only_robot_of_a_user_need_not_be_named(world: World) -> None:
    """The kind: addresses that clients cannot extend, or that people shorten, since there is only one right value."""
    url = f"ws://127.0.0.1:{world.port}/?token={world.token}"
    connecting = asyncio.ensure_future(connect(url, open_timeout=10))
    container = await world.machine.boot(await world.machine.started())
    async with await connecting as robot:
        await say(robot, op="publish", topic="/goal", msg={"data": "x"})
        assert (await next_of(container, robot_link.Deliver)).topic == "goal"
        async with connect(f"{url}&role=operator", open_timeout=10):
            assert {attachment.request.robot for attachment in world.clients.attachments()} == {"tb1"}
    await container.stream.close()


async def test_one_of_several_robots_must_be_named_and_the_refusal_lists_them(world: World) -> None:
    for number in range(MAX_LISTED):
        world.services.store.put_robot(records.robot(f"tb{number + 2:02}", user="ann", map="house"))
    status, problem = await refusal(f"ws://127.0.0.1:{world.port}/?token={world.token}")
    assert (status, problem["type"]) == (422, "urn:ppaas:problem:invalid-parameter")
    assert "?robot=ID with one of tb02, tb03" in problem["detail"] and problem["detail"].endswith(", …")
    assert not world.machine.has_orders()


async def test_a_user_without_robots_is_told_how_to_register_one(world: World) -> None:
    await world.services.accounts.register("bob", PASSWORD)
    token = await world.services.accounts.login("bob", PASSWORD)
    status, problem = await refusal(f"ws://127.0.0.1:{world.port}/?token={token}")
    assert status == 422
    assert "no robot yet" in problem["detail"] and "ppaas robot put" in problem["detail"]


async def test_user_and_token_in_an_address_log_in_and_appear_in_no_log(
    world: World, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG, "endpoints")
    address = f"127.0.0.1:{world.port}/?robot=tb1&role=operator&hold=0"
    async with world.robot(), connect(f"ws://ann:{world.token}@{address}", open_timeout=10) as operator:
        await operator.send("{")
    for wrong in (f"bob:{world.token}", f"ann:{PASSWORD.replace(' ', '')}"):
        assert (await refusal(f"ws://{wrong}@{address}"))[0] == 401
    assert world.token not in caplog.text


async def test_a_page_that_has_a_token_is_still_a_page_of_another_host(world: World) -> None:
    """Pages cannot send a bearer token, but browsers send the user info of an address as Basic credentials."""
    with pytest.raises(InvalidStatus) as refused:
        await connect(
            f"ws://ann:{world.token}@127.0.0.1:{world.port}/?robot=tb1", origin=Origin("https://evil.example")
        )
    assert refused.value.response.status_code == 403


async def test_a_second_robot_is_refused_and_the_first_stays_connected(world: World) -> None:
    async with world.robot() as (robot, container):
        status, problem = await refusal(world.url())
        assert status == 409
        assert "connected already" in problem["detail"]
        await say(robot, op="publish", topic="/goal", msg={"data": "x"})
        assert (await next_of(container, robot_link.Deliver)).topic == "goal"


async def test_a_container_not_ready_in_time_is_a_problem(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rosbridge, "READY_TIMEOUT", 0.05)
    status, problem = await refusal(world.url())
    assert status == 503
    assert "no container was ready" in problem["detail"]


async def test_a_launch_error_of_the_container_is_returned_unchanged(world: World) -> None:
    refused = asyncio.create_task(refusal(world.url()))
    order = await world.machine.started()
    error = NotFound("model", "toaster", ["turtlebot2"])
    world.machine.tell(control_link.LaunchFailed(order.spec.id, Refusal(error.slug, str(error))))
    status, problem = await refused
    assert (status, problem["detail"]) == (404, "unknown model 'toaster'; known: turtlebot2")


async def test_disconnecting_before_the_container_is_ready_closes_the_place(
    world: World, caplog: pytest.LogCaptureFixture
) -> None:
    _, writer = await asyncio.open_connection("127.0.0.1", world.port)
    path = world.url().partition(str(world.port))[2]
    writer.write(
        f"GET {path} HTTP/1.1\r\nHost: cloud\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n".encode()
    )
    order = await world.machine.started()
    writer.close()
    await writer.wait_closed()
    container = await world.machine.boot(order)
    await until(lambda: world.service.place(KEY) is None)
    assert await next_of(container, robot_link.Shutdown)
    assert [record for record in caplog.records if record.levelno >= logging.ERROR] == []


# -- roles, and which client gets what ---------------------------------------------------------------------------------


async def test_robot_messages_reach_the_clone_and_goals_are_numbered(world: World) -> None:
    async with world.robot() as (robot, container):
        await say(robot, op="publish", topic="/scan", msg={"ranges": [1.5]})
        await say(robot, op="publish", topic="goal", msg={"data": "kitchen"})
        scan, goal = await next_of(container, robot_link.Deliver), await next_of(container, robot_link.Deliver)
        assert (scan.topic, json.loads(scan.payload), scan.sequence) == ("scan", {"ranges": [1.5]}, 0)
        assert (goal.topic, json.loads(goal.payload), goal.sequence) == ("goal", {"data": "kitchen"}, 1)


async def test_an_operator_publishes_goals_but_no_sensor_data(world: World) -> None:
    async with world.robot() as (_, container), world.connected("operator", status="1") as operator:
        await say(operator, op="publish", topic="/scan", msg={})
        await say(operator, op="advertise", topic="/odom", type="nav_msgs/Odometry")
        await say(operator, op="publish", topic="/goal", msg={"data": "x"})
        for _ in range(2):
            status = await hear(operator)
            assert (status["op"], status["level"]) == ("status", "error")
            assert status["msg"].startswith("not-permitted: only the robot itself may publish")
        assert (await next_of(container, robot_link.Deliver)).topic == "goal"


async def test_status_messages_are_sent_once_the_client_requests_them(world: World) -> None:
    async with world.robot() as (robot, container):
        await robot.send("{")
        await say(robot, op="set_level", level="error")
        await say(robot, op="publish", topic="/nowhere", msg={}, id="p1")
        status = await hear(robot)
        assert status["msg"].startswith("not-found: unknown topic 'nowhere'; known: cmd_vel, goal, map")
        assert status["id"] == "p1"
        await robot.send(b"\xff\x01")
        assert (await hear(robot))["msg"].startswith("malformed-message: a binary frame must be JSON")
        await say(robot, op="publish", topic="/goal", msg={})
        refused = await next_of(container, robot_link.Deliver)
        container.stream.write(
            robot_link.MessageRefused(refused.client, "goal", Refusal("malformed-message", "no data"))
        )
        assert (await hear(robot))["msg"] == "malformed-message: no data"


async def test_warnings_logged_for_one_client_are_bounded(world: World, caplog: pytest.LogCaptureFixture) -> None:
    async with world.robot(status="1") as (robot, container):
        await say(robot, op="publish", topic="/goal", msg={})
        client = (await next_of(container, robot_link.Deliver)).client
        for number in range(3 * MAX_LOGGED):
            container.stream.write(
                robot_link.MessageRefused(client, f"t{number}", Refusal("not-found", "unknown topic"))
            )
        container.stream.write(robot_link.MessageRefused(client, "end", Refusal("conflict", "the end")))
        while "the end" not in (await hear(robot))["msg"]:
            pass
        warnings = [r for r in caplog.records if r.name == session.__name__ and r.levelno == logging.WARNING]
        assert len(warnings) == MAX_LOGGED


# -- topics and services -----------------------------------------------------------------------------------------------


async def test_a_topic_is_delivered_as_spelled_until_unsubscribed(world: World) -> None:
    async with world.robot() as (robot, container), world.connected("operator") as operator:
        await say(robot, op="subscribe", topic="/map", id="one")
        assert await next_of(container, robot_link.SubscribeTopic)
        container.stream.write(robot_link.Published("map", b'{"data":[0]}'))
        assert await hear(robot) == {"op": "publish", "topic": "/map", "msg": {"data": [0]}}
        await say(robot, op="unsubscribe", topic="map", id="another")
        await say(robot, op="unsubscribe", topic="map", id="one")
        assert (await next_of(container, robot_link.UnsubscribeTopic)).topic == "map"
        await say(operator, op="subscribe", topic="cmd_vel")
        assert await next_of(container, robot_link.SubscribeTopic)
        container.stream.write(robot_link.Published("cmd_vel", b"{}"))
        assert await hear(operator) == {"op": "publish", "topic": "cmd_vel", "msg": {}}


async def test_calls_are_bounded_and_answered_or_failed(world: World) -> None:
    async with world.robot() as (robot, container):
        for number in range(MAX_CALLS + 1):
            await say(robot, op="call_service", service="/make_plan", id=str(number), args={"n": number})
        refused = await hear(robot)
        assert (refused["id"], refused["result"]) == (str(MAX_CALLS), False)
        assert "pending calls" in refused["values"]
        calls = [await next_of(container, robot_link.ServiceCall) for _ in range(MAX_CALLS)]
        assert [json.loads(call.payload) for call in calls] == [{"n": n} for n in range(MAX_CALLS)]
        container.stream.write(robot_link.ServiceAnswer(calls[1].call, b'{"plan":1}'))
        assert await hear(robot) == {
            "op": "service_response", "service": "/make_plan", "id": "1", "result": True, "values": {"plan": 1},
        }  # fmt: skip
        await world.machine.kill(container)
        await world.machine.boot(await world.machine.started())
        failed = [await hear(robot) for _ in range(MAX_CALLS - 1)]
        assert all(not answer["result"] and "lost" in answer["values"] for answer in failed)


# -- the end -----------------------------------------------------------------------------------------------------------


async def test_the_place_is_released_when_the_last_client_leaves(world: World) -> None:
    async with world.robot() as (robot, container), world.connected("operator") as operator:
        await say(operator, op="subscribe", topic="/map")
        assert await next_of(container, robot_link.SubscribeTopic)
        await operator.close()
        assert await next_of(container, robot_link.UnsubscribeTopic)
        await robot.close()
        assert await next_of(container, robot_link.Shutdown)
    await until(lambda: world.service.place(KEY) is None)


@pytest.mark.parametrize(
    "text", ["over", "größer als " + "ä" * 200, "🤖" * 100, "x" * 500], ids=["short", "umlauts", "emoji", "long"]
)
async def test_every_client_gets_the_reason_for_a_closed_place(world: World, text: str) -> None:
    async with world.robot() as (robot, _), world.connected("operator") as operator:
        await world.service.close_place(KEY, Unavailable(text))
        for client in (robot, operator):
            code, reason = await closed(client)
            assert code == 1011
            assert f"unavailable: {text}".startswith(reason)
            assert len(reason.encode()) > min(len(text), MAX_REASON - 4)


async def test_a_place_closed_during_the_handshake_is_reported(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    accept = WebSocket.accept

    async def accept_too_late(self: WebSocket, **options: Any) -> None:
        await world.service.close_place(KEY, Unavailable("just now"))
        await accept(self, **options)

    monkeypatch.setattr(WebSocket, "accept", accept_too_late)
    async with world.robot() as (robot, _):
        assert await closed(robot) == (1011, "unavailable: just now")


async def test_a_client_that_does_not_read_its_answers_is_disconnected(
    world: World, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(self: FrameOutbox, frame: str, fragment_size: int, sent: object) -> None:
        raise Unavailable("the client reads too slowly")

    async with world.robot() as (robot, container):
        monkeypatch.setattr(FrameOutbox, "put_answer", full)
        await say(robot, op="call_service", service="/make_plan")
        container.stream.write(robot_link.ServiceAnswer((await next_of(container, robot_link.ServiceCall)).call, b"{}"))
        assert await closed(robot) == (
            1011,
            "unavailable: the client reads too slowly",
        )


async def test_an_internal_error_closes_the_socket_and_is_logged_once(
    world: World, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def broken(self: RosbridgeSession, frame: str) -> None:
        raise ZeroDivisionError("secret detail")

    async with world.robot() as (robot, _):
        monkeypatch.setattr(RosbridgeSession, "receive", broken)
        await say(robot, op="publish", topic="/goal", msg={})
        assert await closed(robot) == (1011, "error: internal error: ZeroDivisionError")
    assert len([record for record in caplog.records if record.exc_info]) == 1


async def test_a_robot_reconnects_at_once_after_an_aborted_connection(world: World) -> None:
    world.linger(1000.0)
    async with world.robot() as (robot, container):
        robot.transport.abort()
        await until(lambda: not world.service.presence.is_here(KEY))
        async with world.connected() as again:
            await say(again, op="publish", topic="/goal", msg={"data": "x"})
            assert (await next_of(container, robot_link.Deliver)).topic == "goal"


# Frames that a client is sent by what its handshake says of it, and content of the messages it sends.


@pytest.mark.parametrize("agent", ["AutobahnPython/24.4.2", "Python/3.11 websockets/15.0.1"])
def test_libraries_of_roslibpy_are_not_sent_png(agent: str) -> None:
    assert not reads_png(agent)


@pytest.mark.parametrize("agent", ["", "Mozilla/5.0 (X11; Linux x86_64)", "my robot, as AutobahnPython/1"])
def test_web_pages_and_other_clients_are_sent_png(agent: str) -> None:
    assert reads_png(agent)


@pytest.mark.parametrize(("query", "compact"), [("robot=a", False), ("robot=a&compact=1", True), ("compact=0", False)])
def test_compact_frames_are_asked_for_in_the_address(query: str, compact: bool) -> None:
    assert parse_connect_request(QueryParams(query)).compact is compact


def test_a_message_received_during_the_handshake_is_text_or_bytes() -> None:
    assert content_of({"type": "websocket.receive", "text": ""}) == (b"", False)
    assert content_of({"type": "websocket.receive", "text": "ö"}) == ("ö".encode(), False)
    assert content_of({"type": "websocket.receive", "bytes": b"\xff"}) == (b"\xff", True)


@pytest.fixture
def crowded(world: World) -> World:
    """Return a cloud in which ann has three robots and may have one container."""
    for name in ("tb2", "tb3"):
        world.services.store.put_robot(records.robot(name, user="ann", map="house"))
    limit(world, 1)
    return world


def limit(world: World, containers: int) -> None:
    user: User = world.services.store.user("ann")
    changed = User(user.id, user.password_hash, user.role, Limits(containers=containers))
    world.services.store.change_user(changed)
    world.services.accounts.forget_user("ann")
    world.service.set_limits("ann", changed.limits)


async def told(client: ClientConnection) -> dict[str, Any]:
    frame: dict[str, Any] = json.loads(await asyncio.wait_for(client.recv(), 10))
    return frame


# Robots that wait in the queue for a container.


async def test_queued_robots_get_their_positions_and_are_served_in_order(crowded: World) -> None:
    async with (
        crowded.robot() as (first, _),
        connect(crowded.url(robot="tb2", queue="1")) as second,
        connect(crowded.url(robot="tb3", queue="1")) as third,
    ):
        frame = await told(second)
        assert (frame["op"], frame["level"]) == ("status", "info")
        assert frame["msg"] == "queued: position 1 in the queue"
        assert (await told(third))["msg"] == "queued: position 2 in the queue"
        await first.close()
        assert (await told(second))["msg"] == "queued: the robot left the queue: its container starts"
        assert (await told(third))["msg"] == "queued: position 1 in the queue"
        assert isinstance(await crowded.machine.order(), StopContainer)
        container = await crowded.machine.boot(await crowded.machine.started())
        assert crowded.service.place("robot:ann/tb2") is not None
        limit(crowded, 2)
        assert "left the queue" in (await told(third))["msg"]
        other = await crowded.machine.boot(await crowded.machine.started())
        for booted in (container, other):
            await booted.stream.close()


async def test_a_client_that_disconnects_leaves_the_queue(crowded: World) -> None:
    crowded.linger(30.0)
    async with crowded.robot():
        async with connect(crowded.url(robot="tb2", queue="1")) as second:
            await told(second)
        await until(lambda: crowded.service.position("robot:ann/tb2") is None)
        assert crowded.service.place("robot:ann/tb2") is None


async def test_a_client_that_does_not_request_the_queue_is_refused(crowded: World) -> None:
    async with crowded.robot():
        with pytest.raises(InvalidStatus) as refused:
            await connect(crowded.url(robot="tb2"))
        assert refused.value.response.status_code == 429
        async with connect(crowded.url(robot="tb2", queue="1")) as second:
            await told(second)
            with pytest.raises(InvalidStatus) as refused:
                await connect(crowded.url("operator", robot="tb2"))
            assert refused.value.response.status_code == 503
            assert crowded.service.position("robot:ann/tb2") == 1, "an operator who is refused costs nobody the place"


async def test_a_queued_robot_is_not_idle(crowded: World) -> None:
    async with crowded.robot(), connect(crowded.url(robot="tb2", queue="1")) as second:
        await told(second)
        place = crowded.service.place("robot:ann/tb2")
        assert place is not None and place.busy


def test_the_software_of_a_client_is_its_name_or_its_user_agent() -> None:
    assert parse_connect_request({"robot": "tb1", "software": "acme 3.2"}).software == "acme 3.2"
    assert parse_connect_request({"robot": "tb1"}).software == ""
    assert software_of("acme/3.2\x1b[31m") == "acme/3.2[31m"
    assert len(software_of("a" * 1000)) == LONGEST_SOFTWARE
    for name in ("a" * (LONGEST_SOFTWARE + 1), "acme\n3.2"):
        with pytest.raises(InvalidParameter, match="software must be at most 128 printable characters"):
            parse_connect_request({"robot": "tb1", "software": name})
