"""The agent process is kept running; a script replaces the agent."""

import asyncio
import signal
import sys
from asyncio.subprocess import Process
from pathlib import Path
from typing import Any

import psutil
import pytest

from engine.agent.config import AgentConfig
from engine.local import kept_process
from engine.local.kept_process import KeptProcess, SpareProcesses
from tests.support.waiting import until

STAND_IN = (sys.executable, "-m", "tests.support.engine.agent_stand_in")


class AgentUnderTest:
    """A ``KeptProcess``, and the file that its agents write."""

    def __init__(self, folder: Path, machine: str, spares: SpareProcesses | None = None) -> None:
        self.file = folder / "agents"
        config = AgentConfig(machine, "", "secret", str(folder), "", "memory:", "memory:")
        self.process = KeptProcess("agent", config, STAND_IN, spares=spares)

    def runs(self) -> list[list[int]]:
        """Return the process ids of each run so far, the agent first."""
        try:
            return [[int(pid) for pid in line.split()] for line in self.file.read_text().splitlines()]
        except FileNotFoundError:
            return []


async def test_an_agent_gets_its_settings_only_on_standard_input(tmp_path: Path) -> None:
    agents = AgentUnderTest(tmp_path, "stay")
    await agents.process.start()
    await until(agents.runs)
    assert agents.runs() == [[agents.process.pid]]
    assert "secret" not in " ".join(psutil.Process(agents.process.pid).cmdline())
    await agents.process.stop()


async def test_an_agent_that_is_killed_is_started_again(tmp_path: Path) -> None:
    agents = AgentUnderTest(tmp_path, "stay")
    await agents.process.start()
    await until(agents.runs)
    psutil.Process(agents.runs()[0][0]).send_signal(signal.SIGKILL)
    await until(lambda: len(agents.runs()) == 2)
    await agents.process.stop()
    assert len(agents.runs()) == 2


async def test_a_spare_process_is_used_first_and_another_one_is_started_after_it(tmp_path: Path) -> None:
    before, spares = psutil.Process().children(), SpareProcesses(STAND_IN)
    await spares.start(1)
    [spare] = [child for child in psutil.Process().children() if child not in before]
    agents = AgentUnderTest(tmp_path, "stay", spares)
    await agents.process.start()
    await until(agents.runs)
    assert agents.runs() == [[spare.pid]]
    spare.kill()
    await until(lambda: len(agents.runs()) == 2)
    await agents.process.stop()


async def test_spare_processes_that_died_are_not_used_and_the_rest_are_ended() -> None:
    before, spares = psutil.Process().children(), SpareProcesses(STAND_IN)
    await spares.start(3)
    children = [child for child in psutil.Process().children() if child not in before]
    children[-1].kill()
    await asyncio.sleep(0.2)
    taken = spares.take()
    assert taken is not None
    assert taken.pid == children[-2].pid
    await spares.close()
    assert [child.is_running() for child in children] == [False, True, False]
    taken.kill()
    await taken.wait()


async def test_spare_processes_that_cannot_be_started_are_done_without(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    spares = SpareProcesses((str(tmp_path / "nowhere"),))
    await spares.start(2)
    assert spares.take() is None
    assert "cannot be started ahead" in caplog.text
    await spares.close()


async def test_an_agent_that_keeps_exiting_is_restarted_with_delays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept_process, "RESTART_DELAYS", (0.0, 0.0, 1000.0))
    agents = AgentUnderTest(tmp_path, "die")
    await agents.process.start()
    await until(lambda: len(agents.runs()) == 3)
    await asyncio.sleep(0.3)
    assert len(agents.runs()) == 3
    await agents.process.stop()


async def test_agent_with_the_final_exit_status_is_not_restarted(tmp_path: Path) -> None:
    process = KeptProcess("agent", AgentConfig("die", "", "", str(tmp_path), "", "", ""), STAND_IN, done=3)
    await process.start()
    await process.ended()
    assert len((tmp_path / "agents").read_text().splitlines()) == 1
    await process.stop()


async def test_a_command_that_cannot_be_run_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(kept_process, "RESTART_DELAYS", (0.0,))
    process = KeptProcess("agent", AgentConfig("m", "", "", "", "", "", ""), (str(tmp_path / "nowhere"),))
    await process.start()
    await until(lambda: len(caplog.records) >= 2)
    await process.stop()


async def test_stopping_ends_an_agent_without_a_link(tmp_path: Path) -> None:
    agents = AgentUnderTest(tmp_path, "stay")
    await agents.process.start()
    await until(agents.runs)
    await agents.process.stop()
    assert not psutil.pid_exists(agents.runs()[0][0])
    await agents.process.stop()


async def test_an_agent_that_does_not_end_is_killed_with_what_it_started(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept_process, "STOP_GRACE", 0.2)
    agents = AgentUnderTest(tmp_path, "stubborn")
    await agents.process.start()
    await until(agents.runs)
    ((agent, child),) = agents.runs()
    grandchild = psutil.Process(child)
    await agents.process.stop()
    assert not psutil.pid_exists(agent)
    _, alive = await asyncio.to_thread(psutil.wait_procs, [grandchild], 10)
    assert not alive


async def test_stopping_an_unstarted_process_does_nothing(tmp_path: Path) -> None:
    await AgentUnderTest(tmp_path, "stay").process.stop()


async def test_a_process_that_exits_before_it_gets_its_settings_is_started_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    start, started = kept_process.start_process, 0

    async def slow_start(*arguments: Any) -> Process:
        nonlocal started
        started += 1
        if started > 1:
            return await start(*arguments)
        process = await start((sys.executable, "-c", ""))
        await process.wait()
        await asyncio.sleep(0.1)  # its pipe is closed by now
        return process

    monkeypatch.setattr(kept_process, "start_process", slow_start)
    agents = AgentUnderTest(tmp_path, "stay")
    await agents.process.start()
    await until(agents.runs)
    assert started == 2
    await agents.process.stop()
