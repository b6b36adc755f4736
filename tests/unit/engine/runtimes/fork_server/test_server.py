"""The fork server, and its early start."""

import subprocess
import sys
from multiprocessing import forkserver

import psutil
import pytest

from engine.agent.entries import ENTRIES, loaded_before
from engine.control.master_driver import START_TIMEOUT
from engine.runtimes.entries import Entry
from engine.runtimes.fork_server import early_start
from engine.runtimes.fork_server.server import FORK_TIMEOUT, ForkServer
from engine.runtimes.process.runtime import ProcessRuntime
from engine.runtimes.registry import RUNTIMES
from ppaas.errors import Unavailable
from tests.support.engine.fork_servers import stop_fork_server

ENTRY = "tests.support.engine.container_entries:dial_and_stay"


@pytest.fixture(autouse=True)
def no_fork_server():
    stop_fork_server()


def unexpected() -> None:
    raise AssertionError("the fork server died")


async def test_a_warm_server_reports_itself_and_the_kernels_of_containers():
    server = ForkServer(loaded_before("engine.container.entry:main"))
    report = await server.warm(unexpected)
    assert report.layer in ("tbb", "serial")
    assert any(name.startswith("ppaas.costmap.kernels.") for name in report.kernels)
    assert not any("hub_labels" in name for name in report.kernels), "few robots plan with it"
    again = await server.warm(unexpected)
    assert again.pid == report.pid
    server.close()


async def test_failed_import_raises_and_the_next_server_is_new():
    broken = ForkServer(Entry(ENTRY, ("tests.support.engine.broken_preload",)))
    with pytest.raises(Unavailable, match="the fork server exited during its imports"):
        await broken.warm(unexpected)
    assert not broken.is_warm
    server = ForkServer(loaded_before(ENTRY))
    await server.warm(unexpected)
    assert server.is_warm
    server.close()


async def test_ended_server_is_replaced_and_main_module_unchanged():
    main = sys.modules["__main__"]
    server = ForkServer(loaded_before(ENTRY))
    first = await server.warm(unexpected)
    await server.end()
    assert not server.is_warm
    second = await server.warm(unexpected)
    assert second.pid != first.pid
    assert sys.modules["__main__"] is main
    server.close()


def test_a_frozen_server_is_given_up_before_the_requested_container():
    assert FORK_TIMEOUT < START_TIMEOUT


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
