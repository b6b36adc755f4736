"""An agent under SIGTERM and over several masters: its containers outlive a master that did not dismiss it."""

import asyncio
import importlib
import importlib.util
import os
import signal
from pathlib import Path
from typing import Any, cast

import pytest

from engine.agent.agent import Agent, until_terminated
from engine.agent.components import AgentComponents
from engine.agent.config import AgentConfig
from engine.agent.container_gateway import ContainerGateway
from engine.agent.container_supervisor import ContainerSupervisor
from engine.agent.entries import ENTRIES, FREEZE, PRELOAD, loaded_before
from engine.agent.host_load import HostLoad
from engine.agent.kernel_service import nothing_to_compile
from engine.agent.master_session import Master, MasterRedial, MasterSession, OneMaster
from engine.fabric.router import RouterProcess
from engine.processes.heartbeats import MISSED
from engine.protocols import control_link
from engine.protocols.framing import FrameStream
from engine.runtimes.entries import Entry
from ppaas.clock import ManualClock
from ppaas.errors import Unavailable
from tests.support.engine.engine_links import pair, receive
from tests.support.engine.specs import robot_spec
from tests.support.waiting import until


async def test_sigterm_cancels_the_block() -> None:
    stopped, done = asyncio.Event(), False
    with until_terminated(stopped):
        os.kill(os.getpid(), signal.SIGTERM)
        await asyncio.sleep(60.0)
        done = True
    assert stopped.is_set()
    assert not done


async def test_sigterm_after_the_block_still_sets_the_event() -> None:
    stopped = asyncio.Event()
    with until_terminated(stopped):
        pass
    os.kill(os.getpid(), signal.SIGTERM)
    await until(stopped.is_set)
    await asyncio.sleep(0.0)


RUNNING = control_link.RunningContainer(robot_spec("old"), 1.0, "secret", 42)


class FakeSupervisor:
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


class FakeMasters:
    """Fake address of masters."""

    network = 0.0
    cloud = ""

    def __init__(self) -> None:
        self.kernels = nothing_to_compile()
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


class Directory(OneMaster):
    """A directory in which another master leads once the test says so."""

    other = False
    asked = 0

    async def another_leads(self) -> bool:
        self.asked += 1
        return self.other


def agent_of(
    supervisor: FakeSupervisor, masters: FakeMasters, within: float = 30.0, directory: OneMaster | None = None
) -> tuple[Agent, MasterSession]:
    config = AgentConfig("m1", "", "secret", "", "", "memory:", "memory:", adopt_within=within)
    session = MasterSession(remote=False)
    here = cast(ContainerSupervisor, supervisor), cast(ContainerGateway, masters), session, cast(HostLoad, masters)
    elsewhere = RouterProcess(Path("unused")), directory or OneMaster(""), None
    return Agent(AgentComponents(config, (0,), *here, *elsewhere)), session


async def test_agent_registers_its_containers_and_keeps_those_adopted() -> None:
    masters, supervisor = (
        FakeMasters(),
        FakeSupervisor(RUNNING, control_link.RunningContainer(robot_spec("other"), 1.0, "secret", 43)),
    )
    agent, session = agent_of(supervisor, masters)
    staying = asyncio.create_task(agent.stay(masters.dial))
    first, _ = await masters.registered()
    first.write(control_link.Welcome("cloud 1", ("old", "other")))
    assert await receive(first) == control_link.AgentBeat()
    await until(session.acts)
    await first.close()
    second, register = await masters.registered()
    assert [carried.spec.id for carried in register.carries] == ["old", "other"]
    assert not session.acts(), "until it is welcome"
    second.write(control_link.Welcome("cloud 2", ("old",)))
    await until(session.acts)
    assert (masters.cloud, supervisor.kept[2:], supervisor.endpoints) == ("cloud 2", ["old"], 2)
    second.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)
    assert not session.acts()


async def test_dismissed_agent_ends_although_containers_run() -> None:
    masters = FakeMasters()
    agent, _ = agent_of(FakeSupervisor(RUNNING), masters)
    staying = asyncio.create_task(agent.stay(masters.dial))
    master, _ = await masters.registered()
    master.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)
    assert masters.dialled == 1


async def test_agent_without_containers_registers_with_the_next_master() -> None:
    masters = FakeMasters()
    agent, _ = agent_of(FakeSupervisor(), masters)
    staying = asyncio.create_task(agent.stay(masters.dial))
    first, _ = await masters.registered()
    await first.close()
    second, register = await masters.registered()
    assert register.carries == ()
    second.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)


async def test_agent_without_adoption_time_ends_with_its_master() -> None:
    masters = FakeMasters()
    agent, _ = agent_of(FakeSupervisor(RUNNING), masters, 0.0)
    staying = asyncio.create_task(agent.stay(masters.dial))
    master, _ = await masters.registered()
    await master.close()
    await asyncio.wait_for(staying, 10)
    assert masters.dialled == 1


async def test_agent_ends_if_no_master_welcomes_it_in_time() -> None:
    masters = FakeMasters()
    agent, _ = agent_of(FakeSupervisor(RUNNING), masters, 0.5)
    staying = asyncio.create_task(agent.stay(masters.dial))
    while not staying.done():
        while not masters.ends.empty():
            await masters.ends.get_nowait().close()
        await asyncio.sleep(0.01)
    assert masters.dialled > 1


async def test_redial_repeats_until_the_time_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.agent.master_session.REDIAL_PERIOD", 0.001)
    clock, masters = ManualClock(0.0), FakeMasters()
    masters.away = True

    async def dial() -> Master:
        clock.advance(1.0)
        return await masters.dial()

    assert await MasterRedial(3.5, clock)(dial) is None
    assert masters.dialled == 4
    masters.away = False
    found = await MasterRedial(3.5, clock)(dial)
    assert found is not None
    await found.close()


async def test_agent_refuses_a_master_that_was_replaced_and_waits_for_the_right_one() -> None:
    masters, supervisor = FakeMasters(), FakeSupervisor(RUNNING)
    agent, session = agent_of(supervisor, masters)
    staying = asyncio.create_task(agent.stay(masters.dial))
    for epoch, known in ((2, 0), (1, 2), (3, 2)):
        master, register = await masters.registered()
        assert register.epoch == known
        master.write(control_link.Welcome(f"cloud {epoch}", ("old",) if epoch > 1 else (), epoch))
        if epoch == 1:
            master.write(control_link.StopContainer("old"))
            while not isinstance(said := await receive(master), control_link.Outranked):
                assert said is not None
            assert said == control_link.Outranked(2)
            assert masters.cloud == "cloud 2" and not session.acts()
        else:
            await until(session.acts)
        if epoch < 3:
            await master.close()
    assert (supervisor.kept, supervisor.endpoints) == (["old", "old"], 2)
    master.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)


async def test_agent_leaves_a_master_that_does_not_lead_only_for_one_that_does() -> None:
    masters, directory = FakeMasters(), Directory("")
    agent, session = agent_of(FakeSupervisor(RUNNING), masters, directory=directory)
    staying = asyncio.create_task(agent.stay(masters.dial))
    first, _ = await masters.registered()
    first.write(control_link.Welcome("cloud 1", ("old",), 1))
    first.write(control_link.BeatAcknowledged(leads=True))
    await until(session.acts)
    assert directory.asked == 0
    first.write(control_link.BeatAcknowledged(leads=False))
    await until(lambda: directory.asked == 1)
    assert masters.dialled == 1
    directory.other = True
    first.write(control_link.BeatAcknowledged(leads=False))
    second, _ = await masters.registered()
    second.write(control_link.Welcome("cloud 2", ("old",), 2))
    await until(session.acts)
    assert session.epoch == 2
    second.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)
    await first.close()


async def test_agent_looks_for_another_master_before_it_gives_a_silent_one_up() -> None:
    masters, directory = FakeMasters(), Directory("")
    agent, session = agent_of(FakeSupervisor(RUNNING), masters, directory=directory)
    directory.other = True
    staying = asyncio.create_task(agent.stay(masters.dial))
    first, _ = await masters.registered()
    first.write(control_link.Welcome("cloud 1", ("old",), 1))
    second, _ = await masters.registered()
    assert directory.asked == 1
    assert session.lease.unanswered < MISSED, "the master still counts as alive"
    second.write(control_link.Dismissed())
    await asyncio.wait_for(staying, 10)
    await first.close()


@pytest.mark.parametrize("entry", ENTRIES, ids=ENTRIES._fields)
def test_entry_modules_and_functions_exist(entry: Entry) -> None:
    module, _, function = entry.function.partition(":")
    assert callable(getattr(importlib.import_module(module), function))
    assert [name for name in entry.of_fork_server if importlib.util.find_spec(name) is None] == []


def test_fork_server_preloads_first_and_freezes_last() -> None:
    entry = loaded_before("some.module:main", "and.more")
    assert entry.of_fork_server == (PRELOAD, "some.module", "and.more", FREEZE)
    assert entry.preload == (PRELOAD, "some.module", "and.more"), "nothing is frozen where nothing is forked"
    assert Entry("some.module:main").of_fork_server == ()
