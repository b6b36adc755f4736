"""Sockets of users with whom a robot is shared, and of tokens with a scope."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection

from endpoints.rosbridge import RightsWatch
from engine.protocols import robot_link
from storage.sharing_records import ALL, Share, TokenScope
from tests.support.endpoints.robot_world import PASSWORD, World, closed, hear, next_of, refusal, say, session_headers

DRIVE = Share("bob", "drive", ("cmd_vel", "move_base"), ("odom", "map"))


@pytest.fixture
def watch(world: World) -> RightsWatch:
    return RightsWatch(world.clients, world.services)


def share(world: World, *shares: Share) -> None:
    """Share the robot tb1 of ann with these alone, as the route does."""
    world.services.store.change_shares(world.services.store.robot("ann", "tb1"), shares)
    world.services.shares.forget_robot("ann", "tb1")


async def token_of(world: World, user: str = "bob", *, groups: tuple[str, ...] = ()) -> str:
    await world.services.accounts.register(user, PASSWORD, groups=groups)
    return await world.services.accounts.login(user, PASSWORD)


async def scoped(world: World, role: Any, *, publish: tuple[str, ...] = ALL, robots: tuple[str, ...] = ("tb1",)) -> str:
    scope = TokenScope(robots, role, publish)
    return (await world.services.accounts.issue_scoped("ann", scope, 3600.0)).token


@asynccontextmanager
async def operator(world: World, token: str, **query: str) -> AsyncIterator[ClientConnection]:
    """Connect bob to the robot of ann, with a status of each error."""
    async with world.connected("operator", robot="ann:tb1", token=token, status="1", **query) as client:
        yield client


async def refused(client: ClientConnection, **operation: Any) -> str:
    """Send an operation, and return the text of the status that refuses it."""
    await say(client, **operation)
    answer = await hear(client)
    assert (answer["op"], answer["level"]) == ("status", "error")
    text: str = answer["msg"]
    return text


async def test_a_driver_publishes_and_hears_only_what_is_shared(world: World) -> None:
    share(world, DRIVE)
    async with world.robot() as (_, container), operator(world, await token_of(world)) as bob:
        await say(bob, op="publish", topic="/cmd_vel", type="geometry_msgs/Twist", msg={})
        assert (await next_of(container, robot_link.Deliver)).topic == "cmd_vel"
        assert "you may not publish 'initialpose'" in await refused(bob, op="publish", topic="initialpose", msg={})
        assert "not-permitted" in await refused(bob, op="advertise", topic="initialpose", type="std_msgs/String")
        assert "you may not subscribe to 'scan'" in await refused(bob, op="subscribe", topic="/scan")
        assert "not-permitted" in await refused(bob, op="advertise_service", service="dock", type="std_srvs/Empty")
        await say(bob, op="subscribe", topic="/odom")
        assert (await next_of(container, robot_link.SubscribeTopic)).topic == "odom"


async def test_calls_and_goals_that_are_not_shared_are_answered_with_the_reason(world: World) -> None:
    share(world, DRIVE)
    async with world.robot(), operator(world, await token_of(world)) as bob:
        await say(bob, op="call_service", service="move_base/clear_costmaps", id="1")
        answer = await hear(bob)
        assert (answer["id"], answer["result"]) == ("1", False)
        assert "you may not call 'move_base/clear_costmaps' on robot 'ann:tb1'" in str(answer["values"])
        await say(bob, op="send_action_goal", action="follow_waypoints", action_type="x/y", id="2", args={})
        answer = await hear(bob)
        assert (answer["op"], answer["id"], answer["result"]) == ("action_result", "2", False)
        assert "you may not send a goal to 'follow_waypoints'" in str(answer)


async def test_a_robot_that_is_not_shared_is_unknown(world: World) -> None:
    bob = await token_of(world)
    status, problem = await refusal(world.url("operator", robot="ann:tb1", token=bob))
    assert (status, problem["detail"]) == (404, "unknown robot 'ann:tb1'")
    status, problem = await refusal(world.url("operator", robot="ann:tb9", token=bob))
    assert (status, problem["detail"]) == (404, "unknown robot 'ann:tb9'")
    status, problem = await refusal(world.url("operator", robot="ann:", token=bob))
    assert (status, problem["detail"]) == (422, "the parameter 'robot' names no robot of 'ann': give OWNER:ID")


async def test_only_those_who_administer_a_robot_connect_as_the_robot(world: World) -> None:
    share(world, DRIVE)
    bob = await token_of(world)
    status, problem = await refusal(world.url(robot="ann:tb1", token=bob))
    assert status == 403
    assert "needs the role 'administer' on robot 'ann:tb1'; you have 'drive'" in problem["detail"]
    share(world, Share("bob", "administer", ALL))
    async with world.robot(robot="ann:tb1", token=bob):
        assert world.service.place("robot:ann/tb1") is not None


async def test_an_onlooker_does_not_open_a_container(world: World) -> None:
    share(world, Share("group:hall", "look"))
    token = await token_of(world, groups=("hall",))
    status, problem = await refusal(world.url("operator", robot="ann:tb1", token=token))
    assert (status, "wait until it connects" in problem["detail"]) == (503, True)
    async with world.robot(), operator(world, token) as bob:
        assert "needs the role 'drive'" in await refused(bob, op="publish", topic="cmd_vel", msg={})


async def test_a_socket_is_closed_when_the_robot_is_shared_no_more(world: World, watch: RightsWatch) -> None:
    share(world, DRIVE)
    async with world.robot() as (robot, _), operator(world, await token_of(world)) as bob:
        await watch.check()
        share(world)
        await watch.check()
        code, reason = await closed(bob)
        assert (code, reason) == (1008, "not-permitted: robot 'tb1' of 'ann' is not shared with 'bob'")
        await robot.ping()


async def test_a_socket_is_closed_to_connect_again_when_less_is_shared(world: World, watch: RightsWatch) -> None:
    share(world, DRIVE)
    token = await token_of(world)
    async with world.robot(), operator(world, token, session="s") as bob:
        share(world, Share("bob", "look"))
        await watch.check()
        code, reason = await closed(bob)
        assert (code, reason) == (1011, "unavailable: your rights on robot 'tb1' were changed: connect again")
        async with operator(world, token, session="s") as again:
            assert "needs the role 'drive'" in await refused(again, op="publish", topic="cmd_vel", msg={})


async def test_an_open_socket_gets_what_is_shared_later(world: World, watch: RightsWatch) -> None:
    share(world, Share("bob", "look"))
    async with world.robot() as (_, container), operator(world, await token_of(world)) as bob:
        assert "not-permitted" in await refused(bob, op="publish", topic="cmd_vel", msg={})
        share(world, Share("bob", "drive", ALL))
        await watch.check()
        await say(bob, op="publish", topic="cmd_vel", msg={})
        assert (await next_of(container, robot_link.Deliver)).topic == "cmd_vel"


async def test_a_socket_is_closed_when_its_user_leaves_the_group(world: World, watch: RightsWatch) -> None:
    share(world, Share("group:hall", "look"))
    token = await token_of(world, groups=("hall",))
    async with world.robot(), operator(world, token) as bob:
        await world.services.accounts.change("bob", regroup=lambda _: ())
        await watch.check()
        assert (await closed(bob))[0] == 1008


async def test_an_administrator_connects_to_robots_of_others_while_an_administrator(
    world: World, watch: RightsWatch
) -> None:
    await world.services.accounts.register("root", PASSWORD, "admin")
    token = await world.services.accounts.login("root", PASSWORD)
    async with world.robot(), operator(world, token) as root:
        await watch.check()
        await world.services.accounts.change("root", role="user")
        await watch.check()
        assert (await closed(root))[0] == 1008


async def test_a_token_of_the_robot_itself_connects_as_the_robot_alone(world: World, watch: RightsWatch) -> None:
    token = await scoped(world, "robot", publish=("scan", "odom"))
    async with world.robot(token=token, status="1") as (robot, container):
        await watch.check()
        await say(robot, op="publish", topic="scan", msg={})
        assert (await next_of(container, robot_link.Deliver)).topic == "scan"
        assert "this token may not publish 'cmd_vel'" in await refused(robot, op="publish", topic="cmd_vel", msg={})
        status, problem = await refusal(world.url("operator", token=token))
        assert (status, "connect with role=robot" in problem["detail"]) == (403, True)


async def test_a_token_is_refused_at_robots_beyond_its_scope(world: World) -> None:
    token = await scoped(world, "drive", robots=("kobuki",))
    status, problem = await refusal(world.url("operator", token=token))
    assert (status, problem["detail"]) == (403, "this token is for the robots kobuki, and not for 'tb1'")
    looks = await scoped(world, "look")
    async with world.robot(), world.connected("operator", token=looks, status="1") as client:
        assert "this token has 'look'" in await refused(client, op="publish", topic="cmd_vel", msg={})


async def test_users_do_not_take_over_each_others_sessions_at_a_shared_robot(world: World) -> None:
    share(world, DRIVE)
    token = await token_of(world)
    async with (
        world.robot(),
        operator(world, token, session="s") as bob,
        world.connected("operator", session="s") as ann,
    ):
        await bob.ping()
        await ann.ping()


@pytest.mark.parametrize("name", ["s", "mine"])
async def test_a_session_id_of_another_user_begins_a_new_session(world: World, name: str) -> None:
    share(world, DRIVE)
    token = await token_of(world)
    async with world.robot() as (_, container), world.connected("operator", session="s", resume="none") as ann:
        await say(ann, op="subscribe", topic="/odom")
        await next_of(container, robot_link.SubscribeTopic)
        stolen = session_headers(ann)[1]
        async with operator(world, token, session=name, resume=f"{stolen}.0") as bob:
            state, session, taken = session_headers(bob)
            assert (state, taken) == ("new", 0) and session != stolen
            container.stream.write(robot_link.Published("odom", b"{}"))
            assert (await hear(ann))["topic"] == "/odom", "she keeps her socket and her session"
            await say(bob, op="publish", topic="map", msg={})
            assert (await hear(bob))["op"] == "status", "he got none of her frames before this answer"
