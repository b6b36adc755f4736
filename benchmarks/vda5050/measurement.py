"""Measurement of a bridge that presents robots as AGVs: its CPU time, its memory, and the states that arrive."""

import asyncio
import os
import shutil
import socket
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import psutil
from aiomqtt import Client, MqttError

from benchmarks.harness.figures import Figure
from benchmarks.vda5050.fleet_stand_in import fleet_stand_in
from ppaas.clock import monotonic
from ppaas.errors import InvalidInput, Unavailable
from robots import cli

if TYPE_CHECKING:
    from rich.progress import Progress

START_TIMEOUT = 60.0
"""Time within which all AGVs report [s]."""

SHARE_LIMIT = 10.0
"""Largest share of a core for 200 AGVs [%]."""

MEASURED_ROBOTS = 200
"""Number of AGVs that the limit is for."""


async def measure(progress: "Progress", robots: int, seconds: float) -> list[Figure]:
    """Return the figures of a bridge with some robots, measured for a time [s].

    Raises
    ------
    InvalidInput
        mosquitto is not installed.
    Unavailable
        The AGVs did not report in time.
    """
    task = progress.add_task("vda5050", total=2)
    with tempfile.TemporaryDirectory() as folder:
        async with _broker(Path(folder)) as port, fleet_stand_in() as url, _states(port) as arrived:
            names = [f"r{index}" for index in range(robots)]
            bridge = _start(names, port, url, Path(folder) / "bridge.log")
            try:
                await _all_report(bridge, arrived, robots)
                progress.advance(task)
                figures = await _measured(bridge, arrived, robots, seconds)
                progress.advance(task)
            finally:
                bridge.terminate()
                await asyncio.to_thread(bridge.wait, 30)
    return figures


async def _measured(
    bridge: subprocess.Popen[bytes], arrived: "Counter[str]", robots: int, seconds: float
) -> list[Figure]:
    process = psutil.Process(bridge.pid)
    before, since, spent = arrived.total(), monotonic(), sum(process.cpu_times()[:2])
    await asyncio.sleep(seconds)
    passed = monotonic() - since
    share = 100.0 * (sum(process.cpu_times()[:2]) - spent) / passed
    states = (arrived.total() - before) / passed / robots
    part, limit = f"{robots} AGVs", SHARE_LIMIT if robots == MEASURED_ROBOTS else None
    return [
        Figure(part, "states of an AGV", round(states, 2), "1/s", note="that arrived, with poses at 5 Hz"),
        Figure(part, "share of a core", round(share, 1), "%", limit=limit),
        Figure(part, "memory", round(process.memory_info().rss / 1e6, 1), "MB"),
    ]


def _start(names: list[str], port: int, url: str, log: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", cli.__name__, "bridge", "vda5050", *names]
    options = ["--broker", f"mqtt://127.0.0.1:{port}", "--url", url, "--token", "none", "--visualization", "0"]
    with log.open("wb") as output:
        return subprocess.Popen([*command, *options, "--state-interval", "1"], stdout=output, stderr=output)


async def _all_report(bridge: subprocess.Popen[bytes], arrived: "Counter[str]", robots: int) -> None:
    deadline = monotonic() + START_TIMEOUT
    while len(arrived) < robots:
        if bridge.poll() is not None or monotonic() > deadline:
            raise Unavailable(f"{len(arrived)} of {robots} AGVs report")
        await asyncio.sleep(0.1)
    await asyncio.sleep(2.0)  # until the start is over


@asynccontextmanager
async def _states(port: int) -> AsyncIterator["Counter[str]"]:
    """Count the states that arrive, by topic."""
    arrived: Counter[str] = Counter()

    async def listen(client: Client) -> None:
        async for message in client.messages:
            arrived[message.topic.value] += 1

    async with Client("127.0.0.1", port) as client:
        await client.subscribe("uagv/v2/+/+/state")
        listening = asyncio.create_task(listen(client))
        try:
            yield arrived
        finally:
            listening.cancel()
            await asyncio.gather(listening, return_exceptions=True)


@asynccontextmanager
async def _broker(folder: Path) -> AsyncIterator[int]:
    """Run mosquitto on a free port of the loopback interface."""
    program = shutil.which("mosquitto", path=f"{os.environ['PATH']}:/usr/sbin")
    if program is None:
        raise InvalidInput("this bench needs mosquitto: install Debian's package (make broker)")
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port: int = listener.getsockname()[1]
    config = folder / "mosquitto.conf"
    config.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\npersistence false\nuser root\n")
    with (folder / "mosquitto.log").open("wb") as log:
        process = await asyncio.create_subprocess_exec(program, "-c", str(config), stdout=log, stderr=log)
    try:
        await _wait_for(port)
        yield port
    finally:
        process.terminate()
        await process.wait()


async def _wait_for(port: int) -> None:
    deadline = monotonic() + START_TIMEOUT
    while True:
        try:
            async with Client("127.0.0.1", port):
                return
        except MqttError:
            if monotonic() > deadline:
                raise
            await asyncio.sleep(0.05)
