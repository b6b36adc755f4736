"""SIGTERM to a bench or a demo stops all processes that it started."""

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil
import pytest

from benchmarks.chaos.cloud_processes import cloud_processes
from robots import cli
from robots.cli.event_loop import TERMINATED
from tests.support.waiting import wait_until
from tests.support.world import barn

pytestmark = pytest.mark.journey

TIMEOUT = 150.0


@contextmanager
def running(folder: Path, *arguments: str) -> Iterator[subprocess.Popen[bytes]]:
    """Run a command with a folder for all temporary files."""
    command = [sys.executable, "-m", cli.__name__, *arguments]
    process = subprocess.Popen(command, env=os.environ | {"TMPDIR": str(folder)}, stdout=subprocess.DEVNULL)
    try:
        yield process
    finally:
        for left in cloud_processes(folder):
            with suppress(psutil.NoSuchProcess):
                left.process.kill()
        process.wait()


def wait_for(process: subprocess.Popen[bytes], holds: Callable[[], object]) -> None:
    """Wait until a condition holds while the process runs."""

    def does_while_it_runs() -> object:
        assert process.poll() is None
        return holds()

    wait_until(does_while_it_runs, TIMEOUT)


@pytest.mark.parametrize(
    "arguments", [("bench", "service", "--only", "fleet"), ("demo", "--headless", "--robots", "1")]
)
def test_sigterm_to_a_bench_or_demo_stops_its_cloud(short_path: Path, arguments: tuple[str, ...]) -> None:
    with running(short_path, *arguments) as process:
        wait_for(process, lambda: any(short_path.glob("ppaas-*/ready.json")))
        assert {"master", "endpoint", "agent"} <= {member.kind for member in cloud_processes(short_path)}
        process.send_signal(signal.SIGTERM)
        assert process.wait(TIMEOUT) == TERMINATED
    assert cloud_processes(short_path) == []
    assert list(short_path.glob("ppaas-*")) == []


def test_sigterm_to_a_bench_stops_its_pool_of_processes(short_path: Path) -> None:
    worlds = barn.write(short_path / "worlds.json", barn.world(3), barn.world(9))
    with running(short_path, "bench", "barn", str(worlds), "--runs", "1000", "--jobs", "2") as process:
        workers = psutil.Process(process.pid).children
        wait_for(process, lambda: sum(worker.cpu_times().user > 1.0 for worker in workers()) == 2)
        process.send_signal(signal.SIGTERM)
        assert process.wait(TIMEOUT) == TERMINATED
    wait_for_none(short_path)


def wait_for_none(folder: Path) -> None:
    """Wait until no process is left; Python's resource tracker exits shortly after its process."""
    wait_until(lambda: not cloud_processes(folder), 5.0)
