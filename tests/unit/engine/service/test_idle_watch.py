"""Idle clients are disconnected, unless their robot has a goal."""

import asyncio

import pytest

from endpoints.rosbridge.idle_watch import IdleWatch
from engine.protocols import robot_link
from ppaas.clock import ManualClock
from tests.support.endpoints.robot_world import World, closed, next_of, say
from tests.support.waiting import until

IDLE = 100.0


@pytest.fixture
def watch(world: World, clock: ManualClock) -> IdleWatch:
    return IdleWatch(world.clients, world.sessions, IDLE, clock)


async def test_idle_clients_are_disconnected_and_the_container_is_stopped(
    world: World, watch: IdleWatch, clock: ManualClock
) -> None:
    async with world.robot() as (robot, container), world.connected("operator") as operator:
        await watch.check()
        clock.advance(IDLE - 1.0)
        await watch.check()
        assert len(world.service.containers(None)) == 1
        clock.advance(1.0)
        await watch.check()
        for client in (robot, operator):
            code, reason = await closed(client)
            assert code == 1011
            assert reason.startswith("idle: no frames for 100 s: connect again when")
        assert world.service.containers(None) == []
        assert await next_of(container, robot_link.Shutdown)


async def test_a_frame_of_one_client_keeps_all_clients_connected(
    world: World, watch: IdleWatch, clock: ManualClock
) -> None:
    async with world.robot() as (_, container), world.connected("operator") as operator:
        for number in range(3):
            await watch.check()
            clock.advance(IDLE - 1.0)
            await say(operator, op="publish", topic="/goal", msg={"data": str(number)})
            await next_of(container, robot_link.Deliver)
        await watch.check()
        assert len(world.service.containers(None)) == 1


async def test_a_robot_with_a_goal_is_not_idle(world: World, watch: IdleWatch, clock: ManualClock) -> None:
    async with world.robot() as (robot, container):
        place = world.service.place("robot:ann/tb1")
        assert place is not None
        container.stream.write(robot_link.ContainerBeat(busy=True))
        await until(lambda: place.busy)
        for _ in range(3):
            clock.advance(IDLE)
            await watch.check()
        container.stream.write(robot_link.ContainerBeat(busy=False))
        await until(lambda: not place.busy)
        await watch.check()
        assert len(world.service.containers(None)) == 1, "its time begins when the goal is done"
        clock.advance(IDLE)
        await watch.check()
        assert (await closed(robot))[1].startswith("idle: ")


async def test_an_idle_time_of_zero_disables_the_watch(world: World, clock: ManualClock) -> None:
    async with world.robot():
        await asyncio.wait_for(IdleWatch(world.clients, world.sessions, 0.0, clock).run(), 5)
