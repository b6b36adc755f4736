"""Files and processes of a killed process are removed when the cloud ends or when it misses the process."""

import signal
from pathlib import Path

import pytest

from benchmarks.chaos.cloud_processes import cloud_processes
from engine.agent import main as agent_main
from engine.fabric import router
from tests.faults.test_kill import lives
from tests.support.cloud.cloud import named
from tests.support.cloud.up_process import Up
from tests.support.waiting import until

pytestmark = pytest.mark.journey


def test_a_killed_machine_process_leaves_nothing_when_the_cloud_ends(tmp_path: Path) -> None:
    up = Up(tmp_path)
    up.wait_for(up.ready.exists)
    (agent,) = up.children(agent_main.__name__)
    (server,) = named(agent.children(), "forkserver")
    agent.kill()
    up.wait_for(lambda: not lives(server))
    up.wait_for(lambda: [child for child in up.children(router.__name__) if child.pid != agent.pid])
    assert up.end(signal.SIGTERM) == 0  # it checks its folder for temporary files


def test_a_cloud_that_ends_in_order_leaves_no_stopped_process(tmp_path: Path) -> None:
    up = Up(tmp_path)
    up.wait_for(up.ready.exists)
    (agent,) = up.children(agent_main.__name__)
    (server,) = named(agent.children(), "forkserver")
    server.suspend()  # so that it cannot exit by itself
    up.process.terminate()
    assert up.wait() == 0
    assert not lives(server)


async def test_a_cloud_killed_during_its_start_leaves_nothing(
    tmp_path: Path,
) -> None:
    up = Up(tmp_path)
    up.wait_for(lambda: up.children("multiprocessing.forkserver"))  # so the machine knows its cloud
    up.process.kill()
    up.process.wait()
    await until(lambda: not cloud_processes(up.runs), timeout=30.0)
    up.runs.rmdir()  # fails unless it is empty
