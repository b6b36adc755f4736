"""Early start of the fork server."""

import subprocess
import sys
from multiprocessing import forkserver

import psutil

from engine.agent.entries import ENTRIES
from engine.runtimes.fork_server import early_start
from engine.runtimes.fork_server.server import ForkServer
from engine.runtimes.process.runtime import ProcessRuntime
from engine.runtimes.registry import RUNTIMES
from tests.support.engine.fork_servers import stop_fork_server


def unexpected() -> None:
    raise AssertionError("the fork server died")


async def test_containers_are_forked_from_the_server_started_early() -> None:
    stop_fork_server()
    early_start.begin(ENTRIES.container.of_fork_server)
    server = ForkServer(ENTRIES.container)
    report = await server.warm(unexpected)
    assert report.pid == forkserver._forkserver._forkserver_pid  # type: ignore[attr-defined]
    assert any(name.startswith("ppaas.costmap.kernels.") for name in report.kernels)
    server.close()
    stop_fork_server()


def test_end_waits_for_the_server_even_if_it_imports_or_is_stopped() -> None:
    stop_fork_server()
    early_start.end()  # there is none
    for _ in range(2):
        early_start.begin(ENTRIES.container.of_fork_server)
        server = psutil.Process(forkserver._forkserver._forkserver_pid)  # type: ignore[attr-defined]
        server.suspend()
        early_start.end()
        assert server.status() == psutil.STATUS_ZOMBIE
        early_start.end()
    stop_fork_server()


def test_early_start_serves_the_process_runtime() -> None:
    assert RUNTIMES.load(early_start.RUNTIME) is ProcessRuntime


def test_agent_main_imports_no_slow_modules() -> None:
    code = "import sys, engine.agent.main; print({'numpy', 'asyncio', 'msgspec'} & sys.modules.keys())"
    found = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert found.stdout.strip() == "set()"
