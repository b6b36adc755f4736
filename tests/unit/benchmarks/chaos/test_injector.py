"""Faults of a process that stands in for one of a cloud."""

import asyncio
import math
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import cast

import psutil
import pytest

from benchmarks.chaos import faults
from benchmarks.chaos.cloud_processes import CloudProcessInfo
from benchmarks.chaos.faults import CloudSize, FaultKind, Injector
from robots.client.rest import RestClient
from tests.support.waiting import until


@pytest.fixture
def victim() -> Iterator[psutil.Process]:
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    yield psutil.Process(process.pid)
    process.kill()
    process.wait()


@pytest.fixture
def injecting(victim: psutil.Process, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Injector:
    """Return an injector that does one fault: it stops the victim."""
    monkeypatch.setattr(faults, "cloud_processes", lambda _: [CloudProcessInfo(victim, "router", "local")])
    monkeypatch.setattr(faults, "deck", lambda *_, **__: iter([FaultKind("router", "stop")] * 9))
    return Injector(cast(RestClient, None), tmp_path, Random(1), CloudSize(1), pytest.fail)


async def test_a_stopped_process_continues_after_its_pause(
    injecting: Injector, victim: psutil.Process, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(faults, "LONGEST_STOP", 0.5)
    running = asyncio.create_task(injecting.run(30.0, 30.0))
    await until(lambda: injecting.faults)
    [fault] = injecting.faults
    await until(lambda: fault.until)
    assert fault.until == math.inf
    await until(lambda: victim.status() == psutil.STATUS_STOPPED)
    await until(lambda: fault.until < math.inf)
    assert fault.until - fault.at >= 0.5
    await until(lambda: victim.status() != psutil.STATUS_STOPPED)
    running.cancel()


async def test_a_stopped_process_continues_at_the_end_of_the_run(injecting: Injector, victim: psutil.Process) -> None:
    await injecting.run(0.05, 30.0)
    assert injecting.faults[0].until < math.inf
    await until(lambda: victim.status() != psutil.STATUS_STOPPED)


async def test_the_stop_of_a_process_that_exited_is_over(injecting: Injector, victim: psutil.Process) -> None:
    running = asyncio.create_task(injecting.run(30.0, 30.0))
    await until(lambda: injecting.faults)
    victim.kill()
    await until(lambda: 0.0 < injecting.faults[0].until < math.inf)
    running.cancel()
