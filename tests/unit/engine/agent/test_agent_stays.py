"""An agent over several masters: its containers outlive a master that did not dismiss it."""

import asyncio
from typing import Any, cast

import pytest

from engine.agent.agent import Agent
from engine.agent.components import AgentComponents
from engine.agent.config import AgentConfig
from engine.agent.container_gateway import ContainerGateway
from engine.agent.container_supervisor import ContainerSupervisor
from engine.agent.host_load import HostLoad
from engine.agent.master_redial import Master, MasterRedial
from engine.agent.master_session import MasterSession
from engine.protocols import control_link
from engine.protocols.framing import FrameStream
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from tests.support.engine.engine_links import pair, receive
from tests.support.engine.specs import robot_spec
from tests.support.waiting import until

OURS = control_link.RunningContainer(robot_spec("old"), 1.0, "secret", 42)


class Carrying:
    """Fake container supervisor."""

    def __init__(self, *carried: control_link.RunningContainer) -> None:
        self._carried = carried
        self.kept: list[str] = []
        self.endpoints = 0

    def carried(self) -> tuple[control_link.RunningContainer, ...]:
        return self._carried

    def keep_only(self, containers: tuple[str, ...]) -> None:
        self.kept += containers
        self._carried = tuple(carried for carried in self._carried if carried.spec.id in containers)

    def endpoint_came(self) -> None:
        self.endpoints += 1


class Doors:
    """Fake address of masters."""

    network = 0.0
    cloud = ""

    def __init__(self) -> None:
        self.ends: asyncio.Queue[FrameStream[Any]] = asyncio.Queue()
        self.away = False
        self.dialled = 0

    async def dial(self) -> Master:
        self.dialled += 1
        if self.away:
            raise Unavailable("nobody is there")
        near, far = await pair(control_link.ToAgent, control_link.FromAgent)
        self.ends.put_nowait(far)
        return near

    async def registered(self) -> tuple[FrameStream[Any], control_link.Register]:
        """Return the master's end of the next connection, and the agent's first frame."""
        end = await self.ends.get()
        register = await receive(end)
        assert isinstance(register, control_link.Register)
        return end, register

    async def measure(self) -> control_link.AgentBeat:
        return control_link.AgentBeat()


def agent_of(carrying: Carrying, doors: Doors, within: float = 30.0) -> tuple[Agent, MasterSession]:
    config = AgentConfig("m1", "", "secret", "", "", "memory:", "memory:", adopt_within=within)
    standing = MasterSession(leased=False)
    here = cast(ContainerSupervisor, carrying), cast(ContainerGateway, doors), standing, cast(HostLoad, doors)
    return Agent(AgentComponents(config, (0,), *here)), standing


async def test_it_tells_another_master_what_it_carries_and_keeps_what_that_adopts() -> None:
    doors, carrying = Doors(), Carrying(OURS, control_link.RunningContainer(robot_spec("other"), 1.0, "secret", 43))
    agent, standing = agent_of(carrying, doors)
    staying = asyncio.create_task(agent.stay(doors.dial))
    first, _ = await doors.registered()
    first.write(control_link.Welcome("cloud 1", ("old", "other")))
    assert await receive(first) == control_link.AgentBeat()
    await until(standing.acts)
    await first.close()
    second, register = await doors.registered()
    assert [carried.spec.id for carried in register.carries] == ["old", "other"]
    assert not standing.acts(), "until it is welcome"
    second.write(control_link.Welcome("cloud 2", ("old",)))
    await until(standing.acts)
    assert (doors.cloud, carrying.kept[2:], carrying.endpoints) == ("cloud 2", ["old"], 2)
    second.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)
    assert not standing.acts()


async def test_it_ends_when_it_is_dismissed_whatever_it_carries() -> None:
    doors = Doors()
    agent, _ = agent_of(Carrying(OURS), doors)
    staying = asyncio.create_task(agent.stay(doors.dial))
    master, _ = await doors.registered()
    master.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)
    assert doors.dialled == 1


async def test_it_is_there_for_another_master_though_it_carries_nothing() -> None:
    doors = Doors()
    agent, _ = agent_of(Carrying(), doors)
    staying = asyncio.create_task(agent.stay(doors.dial))
    first, _ = await doors.registered()
    await first.close()
    second, register = await doors.registered()
    assert register.carries == ()
    second.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)


async def test_it_ends_with_its_master_where_nothing_may_wait() -> None:
    doors = Doors()
    agent, _ = agent_of(Carrying(OURS), doors, 0.0)
    staying = asyncio.create_task(agent.stay(doors.dial))
    master, _ = await doors.registered()
    await master.close()
    await asyncio.wait_for(staying, 10)
    assert doors.dialled == 1


async def test_it_gives_up_when_no_master_welcomes_it_in_time_though_some_answer() -> None:
    doors = Doors()
    agent, _ = agent_of(Carrying(OURS), doors, 0.5)
    staying = asyncio.create_task(agent.stay(doors.dial))
    while not staying.done():
        while not doors.ends.empty():
            await doors.ends.get_nowait().close()
        await asyncio.sleep(0.01)
    assert doors.dialled > 1


async def test_it_dials_until_the_time_is_over(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.agent.master_redial.PERIOD", 0.001)
    clock, doors = ManualClock(0.0), Doors()
    doors.away = True

    async def dial() -> Master:
        clock.advance(1.0)
        return await doors.dial()

    assert await MasterRedial(3.5, clock)(dial) is None
    assert doors.dialled == 4
    doors.away = False
    found = await MasterRedial(3.5, clock)(dial)
    assert found is not None
    await found.close()
