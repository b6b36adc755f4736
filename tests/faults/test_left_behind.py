"""Who is killed cannot remove what it had made: nothing of it is left when the cloud ends, or was missed."""

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


def test_of_a_killed_machine_process_nothing_is_left_when_the_cloud_ends(tmp_path: Path) -> None:
    up = Up(tmp_path)
    up.wait_for(up.ready.exists)
    (agent,) = up.children(agent_main.__name__)
    (server,) = named(agent.children(), "forkserver")
    agent.kill()
    up.wait_for(lambda: not lives(server))
    up.wait_for(lambda: [child for child in up.children(router.__name__) if child.pid != agent.pid])
    assert up.end(signal.SIGTERM) == 0  # which looks at its folder for temporary files


async def test_of_a_cloud_that_is_killed_while_it_starts_nothing_is_left_when_its_machine_misses_it(
    tmp_path: Path,
) -> None:
    up = Up(tmp_path)
    up.wait_for(lambda: up.children("multiprocessing.forkserver"))  # so it knows whose machine it is
    up.process.kill()
    up.process.wait()
    await until(lambda: not cloud_processes(up.runs), timeout=30.0)
    up.runs.rmdir()  # so it is empty
