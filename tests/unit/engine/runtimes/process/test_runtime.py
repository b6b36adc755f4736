"""The process runtime, and moves of a running process to other CPUs, with all its threads."""

import asyncio
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from engine.agent.entries import loaded_before
from engine.runtimes.process.container import move_threads
from engine.runtimes.process.runtime import ProcessRuntime
from ppaas.errors import Unavailable
from tests.support.engine.launches import Reports
from tests.support.engine.processes import is_gone
from tests.support.waiting import until

ENTRIES = "tests.support.engine.container_entries"


@pytest.fixture
async def reports(tmp_path):
    async with Reports(tmp_path) as server:
        yield server


@pytest.fixture
async def runtime():
    started = ProcessRuntime(loaded_before(f"{ENTRIES}:dial_and_stay"))
    await started.start()
    yield started
    await started.close()


async def test_a_container_runs_and_is_killed(runtime, reports):
    container = await runtime.launch(reports.launch())
    assert (await reports.next()).pid == container.pid
    container.kill()
    assert await container.wait() == -signal.SIGKILL
    assert is_gone(container.pid)
    container.kill()


async def test_several_tasks_can_wait_for_the_exit(runtime, reports):
    container = await runtime.launch(reports.launch())
    waiting = [asyncio.create_task(container.wait()) for _ in range(3)]
    await asyncio.sleep(0)
    waiting[0].cancel()
    container.kill()
    assert await waiting[1] == await waiting[2] == await container.wait() == -signal.SIGKILL


async def test_a_container_has_its_cpus_threads_session_and_exit_status(reports):
    runtime = ProcessRuntime(loaded_before(f"{ENTRIES}:describe"))
    await runtime.start()
    launch = reports.launch(cpus=(0,), threads=1)
    container = await runtime.launch(launch)
    facts = dict(fact.split("=") for fact in (await reports.next()).text.split())
    assert facts.pop("told_ray_token") == "False"
    assert facts == {"cpus": "0", "threads": "1", "session": "True", "omp": "1", "main": "False", "alone": "1"}
    assert await container.wait() == 7
    await runtime.close()


async def test_container_ignores_sigint_and_ends_on_sigterm(runtime, reports):
    container = await runtime.launch(reports.launch())
    await reports.next()
    os.kill(container.pid, signal.SIGINT)
    os.kill(container.pid, signal.SIGTERM)
    assert await container.wait() == -signal.SIGTERM


async def test_a_container_that_cannot_start_exits_with_a_status(runtime, reports):
    container = await runtime.launch(reports.launch(cpus=(4095,)))
    assert await container.wait() == 1


async def test_cancelled_launch_leaves_no_container(runtime, reports):
    launching = asyncio.create_task(runtime.launch(reports.launch()))
    await asyncio.sleep(0)
    launching.cancel()
    with pytest.raises(asyncio.CancelledError):
        await launching
    await until(lambda: bool(runtime._live) or not runtime._tasks)
    await until(lambda: not runtime._live and not runtime._tasks)


async def test_close_ends_all_containers_and_no_more_start(reports):
    runtime = ProcessRuntime(loaded_before(f"{ENTRIES}:dial_and_stay"))
    await runtime.start()
    containers = await asyncio.gather(*(runtime.launch(reports.launch()) for _ in range(3)))
    await runtime.close()
    assert all(is_gone(container.pid) for container in containers)
    with pytest.raises(Unavailable, match="closed"):
        await runtime.launch(reports.launch())


async def test_a_missing_entry_is_an_error_at_the_start():
    for entry in ("tests.support.nowhere:main", f"{ENTRIES}:nothing"):
        runtime = ProcessRuntime(loaded_before(entry))
        with pytest.raises(Unavailable, match=r"containers cannot start.*(nowhere|nothing)"):
            await runtime.start()
        await runtime.close()


async def test_what_a_killed_child_leaves_is_reaped(runtime):
    """A compiler that is killed leaves its resource tracker, which nobody here has started."""
    code = (
        "import os, time; child = os.fork(); print(child, flush=True) if child else None; time.sleep(60 * bool(child))"
    )
    compiler = await asyncio.create_subprocess_exec(sys.executable, "-c", code, stdout=asyncio.subprocess.PIPE)
    orphan = int(await compiler.stdout.readline())
    compiler.kill()
    await compiler.wait()
    await until(lambda: not psutil.pid_exists(orphan))


BUSY = """
import hashlib, threading
def burn():
    while True:
        hashlib.pbkdf2_hmac("sha256", b"x", b"y", 20000)  # releases the interpreter's lock
threads = [threading.Thread(target=burn) for _ in range(3)]
[thread.start() for thread in threads]
print("busy", flush=True)
"""
SECONDS = 0.5


@pytest.fixture
def busy() -> Iterator[int]:
    with subprocess.Popen([sys.executable, "-c", BUSY], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stdout.readline() == b"busy\n"
        yield process.pid
        process.kill()


def cpus_of(pid: int) -> list[set[int]]:
    return [os.sched_getaffinity(int(task.name)) for task in Path(f"/proc/{pid}/task").iterdir()]


def test_all_threads_move_to_a_cpu_and_back(busy: int) -> None:
    every = os.sched_getaffinity(0)
    one = min(every)
    move_threads(busy, (one,))
    assert cpus_of(busy) == [{one}] * 4
    move_threads(busy, tuple(every))
    assert cpus_of(busy) == [every] * 4


def test_three_busy_threads_on_one_cpu_use_no_more_than_one(busy: int) -> None:
    move_threads(busy, (min(os.sched_getaffinity(0)),))
    process = psutil.Process(busy)
    began, before = time.monotonic(), sum(process.cpu_times()[:2])
    time.sleep(SECONDS)
    used, took = sum(process.cpu_times()[:2]) - before, time.monotonic() - began
    assert used <= 1.15 * took  # the kernel counts CPU time in hundredths of a second


def test_exited_process_is_ignored() -> None:
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    move_threads(process.pid, (0,))
