"""Children that run until their input ends; orphans are adopted and reaped, but for children that others wait for.

The process that runs this may have started a fork server, for which the standard library waits.
"""

import asyncio
import os
import signal
import subprocess
import sys
from asyncio.subprocess import PIPE
from collections.abc import Iterator

import psutil
import pytest

from engine.processes.child_process import OrphanReaper, adopt_orphans, end
from engine.runtimes.fork_server import early_start
from tests.support.waiting import wait_until

DEAF = "import time; print('up', flush=True); time.sleep(60)"


async def test_process_exits_when_its_input_ends() -> None:
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", "import sys; sys.stdin.read()", stdin=PIPE)
    await end(process, 30.0)
    assert process.returncode == 0


async def test_process_that_goes_on_is_killed() -> None:
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", DEAF, stdin=PIPE, stdout=PIPE)
    assert process.stdout is not None
    await process.stdout.readline()
    await end(process, 0.01)
    assert process.returncode == -signal.SIGKILL


ORPHAN = "import os; child = os.fork(); child and print(child)"
"""Prints the id of a child; both exit."""


@pytest.fixture
def adopting() -> Iterator[None]:
    adopt_orphans(True)
    yield
    adopt_orphans(False)


def is_zombie(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def orphan() -> int:
    """Return the id of an adopted process that exits."""
    done = subprocess.run([sys.executable, "-c", ORPHAN], capture_output=True, text=True, check=True)
    return int(done.stdout)


@pytest.mark.usefixtures("adopting")
def test_an_orphan_is_reaped_at_the_second_look() -> None:
    reaper, adopted = OrphanReaper(early_start.server), orphan()
    wait_until(lambda: is_zombie(adopted))
    reaper.look()
    assert is_zombie(adopted), "its parent here, if it has one, gets time to reap it"
    reaper.look()
    assert not psutil.pid_exists(adopted)
    reaper.look()


@pytest.mark.usefixtures("adopting")
def test_a_child_that_another_waits_for_is_left() -> None:
    child = subprocess.Popen([sys.executable, "-c", "raise SystemExit(7)"])
    reaper = OrphanReaper(lambda: (child.pid, *early_start.server()))
    wait_until(lambda: is_zombie(child.pid))
    for _ in range(3):
        reaper.look()
    assert child.wait() == 7


@pytest.mark.usefixtures("adopting")
def test_a_child_that_its_parent_reaps_between_looks_is_forgotten() -> None:
    child = subprocess.Popen([sys.executable, "-c", ""])
    reaper = OrphanReaper(early_start.server)
    wait_until(lambda: is_zombie(child.pid))
    reaper.look()
    assert os.waitstatus_to_exitcode(os.waitpid(child.pid, 0)[1]) == 0
    reaper.look()
