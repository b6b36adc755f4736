"""Joint: a dead process is noticed, its dependents end, and nothing is left."""

import asyncio
import json
import os
import re
import signal
import sys
from asyncio.subprocess import PIPE
from pathlib import Path

import psutil
import pytest

from engine.agent.entries import loaded_before
from engine.agent.layer_builder import LayerBuilder
from engine.agent.map_cache import MapCache, sweep_stale
from engine.runtimes.process.runtime import ProcessRuntime
from engine.specs.containers import LayerSpec
from engine.specs.layer_files import open_layers
from tests.support.engine.launches import Reports
from tests.support.engine.processes import SOON, has_ended, is_gone, zombies
from tests.support.sources import ROOT
from tests.support.storage.records import house, kept
from tests.support.waiting import patience, until

pytestmark = pytest.mark.joint

ENTRY = "tests.support.engine.container_entries:dial_and_stay"


@pytest.fixture
async def reports(tmp_path):
    async with Reports(tmp_path) as server:
        yield server


@pytest.fixture
async def runtime():
    started = ProcessRuntime(loaded_before(ENTRY))
    await started.start()
    yield started
    await started.close()


@pytest.fixture
def none_stays_a_zombie():
    """Return a wait until no process is a zombie but those that tests before this one left."""
    before = set(zombies())
    return lambda: until(lambda: set(zombies()) <= before)  # an exited process is a zombie until its parent reaps it


def fork_server_of(pid: int) -> psutil.Process:
    parent = psutil.Process(pid).parent()
    assert parent is not None
    return parent


def share_of_memory(pid: int, name: str) -> int:
    """Return a figure of a process in KB: ``Pss``, ``Private_Dirty``."""
    found = re.search(rf"^{name}:\s+(\d+) kB", Path(f"/proc/{pid}/smaps_rollup").read_text(), re.MULTILINE)
    assert found is not None
    return int(found[1])


@pytest.mark.parametrize("count", [1, 10])
async def test_containers_start_warm(count, runtime, reports, figure):
    loop = asyncio.get_running_loop()
    for _ in range(2):  # the first ones read files that are not cached yet
        began = loop.time()
        containers = await asyncio.gather(*(runtime.launch(reports.launch()) for _ in range(count)))
        pids = {(await reports.next()).pid for _ in range(count)}
        milliseconds = (loop.time() - began) * 1000.0
        assert pids == {container.pid for container in containers}
        shares = [share_of_memory(pid, "Pss") / 1024 for pid in pids]
        private = [share_of_memory(pid, "Private_Dirty") / 1024 for pid in pids]
        for container in containers:
            container.kill()
        await asyncio.gather(*(container.wait() for container in containers))
    figure(f"launch to running, {count} at once, ms", milliseconds)
    figure(f"PSS of one of {count}, MB", sum(shares) / count)
    figure(f"private memory of one of {count}, MB", sum(private) / count)


async def test_a_killed_container_is_reported_and_leaves_no_zombie(runtime, reports, none_stays_a_zombie, figure):
    loop = asyncio.get_running_loop()
    reported = []
    for _ in range(20):
        container = await runtime.launch(reports.launch())
        await reports.next()
        began = loop.time()
        os.kill(container.pid, signal.SIGKILL)
        async with patience(SOON):
            assert await container.wait() == -signal.SIGKILL
        reported.append((loop.time() - began) * 1000.0)
        assert is_gone(container.pid)
    await none_stays_a_zombie()
    figure("container killed to told, worst of 20, ms", max(reported))


async def test_a_dead_fork_server_ends_its_containers_and_is_replaced(runtime, reports, none_stays_a_zombie, figure):
    containers = [await runtime.launch(reports.launch()) for _ in range(5)]
    for _ in containers:
        await reports.next()
    os.kill(containers[0].pid, signal.SIGSTOP)  # one that cannot react
    server = fork_server_of(containers[1].pid)
    loop = asyncio.get_running_loop()
    began = loop.time()
    server.kill()
    async with patience(SOON):
        statuses = await asyncio.gather(*(container.wait() for container in containers))
    figure("fork server killed to all containers told, ms", (loop.time() - began) * 1000.0)
    assert statuses == [-signal.SIGKILL] * 5
    assert all(is_gone(container.pid) for container in containers)
    replacement = await runtime.launch(reports.launch())
    assert (await reports.next(timeout=60)).pid == replacement.pid
    figure("fork server killed to a new container running, ms", (loop.time() - began) * 1000.0)
    assert fork_server_of(replacement.pid).pid != server.pid
    await none_stays_a_zombie()


async def test_launches_succeed_although_the_fork_server_dies(runtime, reports, none_stays_a_zombie):
    first = await runtime.launch(reports.launch())
    server = fork_server_of(first.pid)
    launching = [asyncio.create_task(runtime.launch(reports.launch())) for _ in range(10)]
    await launching[0]
    server.kill()
    containers = [await task for task in launching]
    ended = [container for container in containers if is_gone(container.pid)]
    for container in containers:
        container.kill()
        async with patience(SOON):
            assert await container.wait() == -signal.SIGKILL
    assert len(ended) < len(containers)
    await none_stays_a_zombie()


async def test_a_frozen_fork_server_is_replaced(runtime, reports, monkeypatch):
    monkeypatch.setattr("engine.runtimes.fork_server.server.FORK_TIMEOUT", 1.0)
    first = await runtime.launch(reports.launch())
    server = fork_server_of(first.pid)
    server.suspend()
    container = await runtime.launch(reports.launch())
    assert fork_server_of(container.pid).pid != server.pid
    assert await first.wait() == -signal.SIGKILL


async def test_layers_are_built_although_the_fork_server_is_frozen(
    runtime, reports, none_stays_a_zombie, tmp_path, monkeypatch
):
    monkeypatch.setattr("engine.runtimes.fork_server.server.FORK_TIMEOUT", 1.0)
    first = await runtime.launch(reports.launch())
    fork_server_of(first.pid).suspend()
    async with patience(60):
        folder = await MapCache(tmp_path / "shm", build=LayerBuilder(kept(house()))).ensure(LayerSpec(house(), 0.18))
    assert open_layers(folder).grid.info.width > 0
    assert await first.wait() == -signal.SIGKILL
    await none_stays_a_zombie()


async def test_a_dead_agent_ends_all_its_processes_within_a_second(tmp_path, figure):
    agent = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "tests.support.stress.agent", str(tmp_path), cwd=ROOT, stdout=PIPE
    )
    assert agent.stdout is not None
    async with patience(90):
        started = json.loads(await agent.stdout.readline())
    family = psutil.Process(agent.pid).children(recursive=True)
    assert {*started["containers"], started["router"]} <= {process.pid for process in family}
    os.kill(started["containers"][0], signal.SIGSTOP)  # frozen; the second holds the interpreter's lock
    loop = asyncio.get_running_loop()
    began = loop.time()
    agent.kill()
    await until(lambda: all(has_ended(pid) for pid in started["containers"]))
    figure("agent killed to its containers gone, ms", (loop.time() - began) * 1000.0)
    await until(lambda: all(has_ended(process.pid) for process in family))
    figure("agent killed to everything gone, ms", (loop.time() - began) * 1000.0)
    await agent.wait()
    shared = Path(started["shared"])
    assert shared in sweep_stale(shared.parent)
    assert shared not in set(shared.parent.iterdir())
