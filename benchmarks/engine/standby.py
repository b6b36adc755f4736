"""Take-over by a standby: time from the death of the leader until the standby serves and has adopted a container."""

import asyncio
import contextlib
import os
import signal
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path
from typing import NamedTuple

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.driving_robot import MAP, grid_to_drive_on
from benchmarks.engine.options import EngineOptions
from benchmarks.harness.cloud_under_test import CloudUnderTest, logged_in
from benchmarks.harness.figures import Figure, median_and_worst
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.joining import JoinedMachine, ticket_of
from engine.remote.replica import LAST
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from robots.client.rest import RestClient
from robots.client.robot_client import RobotClient
from robots.demo.cloud_process import CloudProcess

PART = "standby"
SAMPLES, QUICK = 3, 1
LIMIT_MS = 5000.0
ADOPT_WITHIN = 15.0
"""Time for which containers outlive their leader [s]."""

PATIENCE = 30.0
"""Time within which a standby must be ready, and must have adopted the container [s]."""

SETTLED = 2.0
"""Time after which a standby that has the files of its leader watches the lease [s]."""

ROBOT, MACHINE = "bench-standby", "bench-far"
FAULTS = {"leader killed": signal.SIGKILL, "leader stopped": signal.SIGSTOP}


class TakeOver(NamedTuple):
    """Times from the fault until the standby serves, and until it has adopted a container of a joined machine [s]."""

    serves: float
    adopted: float


async def measure(options: EngineOptions, progress: Progress) -> list[Figure]:
    """Let a standby take over from leaders that are killed and stopped, a new pair of processes each time."""
    figures: list[Figure] = []
    for name, fault in tuple(FAULTS.items())[: options.of(len(FAULTS), 1)]:
        samples = progress.track(range(options.of(SAMPLES, QUICK)), description=name)
        found = [await _take_over(fault) for _ in samples]
        note = f"{fault.name} of a cloud process with SQLite and a joined machine, until the standby"
        figures += median_and_worst(
            PART, f"{name}, served", [one.serves for one in found], limit=LIMIT_MS, note=f"{note} serves"
        )
        figures += median_and_worst(
            PART, f"{name}, adopted", [one.adopted for one in found], limit=LIMIT_MS, note=f"{note} has its container"
        )
    return [*figures, baselines.python_figure(PART, [await baselines.python() for _ in range(SAMPLES)])]


async def _take_over(fault: signal.Signals) -> TakeOver:
    with tempfile.TemporaryDirectory(prefix="s-", ignore_cleanup_errors=True) as name:
        folder, ports = Path(name), free_ports(4)
        stores = ("--store", f"sqlite:///{folder / 'store.sqlite'}", "--map-store", f"file:///{folder / 'maps'}")
        common = (*stores, "--adopt-within", str(ADOPT_WITHIN))
        leading = CloudProcess(arguments=(*common, "--listen-machines", f"127.0.0.1:{ports[0]}"))
        async with leading as leader, _joined(leader, folder / "far") as target:
            invitation = await ticket_of(leader.folder / "data", "--standby", "bench")
            standby = CloudProcess(
                arguments=(*common, "--listen-machines", f"127.0.0.1:{ports[2]}", "--standby", invitation)
            )
            try:
                await _stands_by(standby)
                return await _fail(target, leader.ready.pid, fault, standby)
            finally:
                await standby.stop()


@contextlib.asynccontextmanager
async def _joined(leader: CloudProcess, folder: Path) -> AsyncIterator[CloudUnderTest]:
    """Let a machine join, and a robot have its container there."""
    target = await logged_in(leader)
    machine = await JoinedMachine.start(MACHINE, folder, await ticket_of(leader.folder / "data"))
    try:
        await machine.is_in(target.rest)
        await target.rest.patch("/v1/machines/local", {"max_containers": 0})
        await target.publish(MAP, grid_to_drive_on())
        await target.register(ROBOT, MAP, (2.0, 2.0, 0.0))
        async with RobotClient(target.url, robot=ROBOT, token=target.token):
            yield target
    finally:
        await machine.end()


async def _stands_by(standby: CloudProcess) -> None:
    await standby.begin()
    began = monotonic()
    while not (standby.folder / "data" / LAST).exists():
        if monotonic() - began > PATIENCE:
            raise Unavailable(f"the standby has not copied the files of its leader within {PATIENCE:g} s")
        await asyncio.sleep(0.05)
    await asyncio.sleep(SETTLED)


async def _fail(target: CloudUnderTest, leader: int, fault: signal.Signals, standby: CloudProcess) -> TakeOver:
    before = await _container(target.rest)
    failed = monotonic()
    os.kill(leader, fault)
    try:
        await standby.is_up()
        serves = monotonic() - failed
        rest = RestClient(standby.ready.url, target.token)
        while await _container(rest) != before:
            if monotonic() - failed > PATIENCE:
                raise Unavailable(f"the standby has not adopted container {before} within {PATIENCE:g} s")
            await asyncio.sleep(0.02)
        return TakeOver(serves, monotonic() - failed)
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.kill(leader, signal.SIGCONT)  # it finds out that it was replaced, and ends


async def _container(rest: RestClient) -> tuple[str, int] | None:
    found = [view for view in await rest.items("/v1/containers") if view["robot"] == ROBOT and view["pid"]]
    return (found[0]["id"], found[0]["pid"]) if found else None
