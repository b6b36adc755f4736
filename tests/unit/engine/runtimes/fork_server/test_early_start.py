"""The fork server that is started before anything else."""

import subprocess
import sys
from multiprocessing import forkserver

from engine.agent.entries import ENTRIES
from engine.runtimes.fork_server import early_start
from engine.runtimes.fork_server.server import ForkServer
from engine.runtimes.process.runtime import ProcessRuntime
from engine.runtimes.registry import RUNTIMES


def unexpected() -> None:
    raise AssertionError("the fork server died")


async def test_the_one_that_was_begun_is_the_one_that_containers_are_forked_from() -> None:
    forkserver._forkserver._stop()  # type: ignore[attr-defined]
    early_start.begin(ENTRIES.container.of_fork_server)
    server = ForkServer(ENTRIES.container)
    warmth = await server.warm(unexpected)
    assert warmth.pid == forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    assert any(name.startswith("ppaas.costmap.kernels.") for name in warmth.kernels)
    server.close()
    forkserver._forkserver._stop()  # type: ignore[attr-defined]


def test_it_is_that_of_the_runtime_of_its_name() -> None:
    assert RUNTIMES.load(early_start.RUNTIME) is ProcessRuntime


def test_nothing_that_takes_long_is_loaded_before_it() -> None:
    code = "import sys, engine.agent.main; print({'numpy', 'asyncio', 'msgspec'} & sys.modules.keys())"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout.strip() == "set()"
