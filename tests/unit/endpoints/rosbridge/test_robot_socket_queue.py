"""Robots that wait in the queue for a container."""

import asyncio
import json
from typing import Any

import pytest
from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import InvalidStatus

from engine.protocols.control_link import StopContainer
from storage.records import Limits, User
from tests.support.endpoints.robot_world import World
from tests.support.storage import records
from tests.support.waiting import until


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
