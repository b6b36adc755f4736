"""Processes of the VDA 5050 bench: mosquitto on a port of this machine, and a bridge with its figures."""

import asyncio
import os
import shutil
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

import psutil
from aiomqtt import Client, MqttError

from benchmarks.harness.figures import Figure
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.process_usage import share_of_core
from ppaas.clock import monotonic
from ppaas.errors import InvalidInput, Unavailable
from robots import cli

START_TIMEOUT = 60.0
"""Time within which the broker answers [s]."""


@asynccontextmanager
async def broker(folder: Path) -> AsyncIterator[int]:
    """Run mosquitto on a free port of the loopback interface."""
    program = shutil.which("mosquitto", path=f"{os.environ['PATH']}:/usr/sbin")
    if program is None:
        raise InvalidInput("this bench needs mosquitto: install Debian's package (make broker)")
    [port] = free_ports(1)
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


SHARE_LIMIT = 10.0
"""Largest share of a core for 200 AGVs [%]."""

MEASURED_ROBOTS = 200
"""Number of AGVs that the limit is for."""


class BridgeProcess:
    """Running bridge with some AGVs.

    Parameters
    ----------
    process : asyncio.subprocess.Process
    agvs : int
        Number of AGVs.
    """

    def __init__(self, process: asyncio.subprocess.Process, agvs: int) -> None:
        self._process = process
        self._agvs = agvs

    async def until_all(self, count: Callable[[], int], doing: str, settle: float) -> None:
        """Wait until ``count`` returns the number of AGVs, and then until the start is over, ``settle`` seconds.

        Raises
        ------
        Unavailable
            The bridge has exited, or they are not there in time; the text says that they ``doing``.
        """
        deadline = monotonic() + START_TIMEOUT
        while count() < self._agvs:
            if self._process.returncode is not None or monotonic() > deadline:
                raise Unavailable(f"{count()} of {self._agvs} AGVs {doing}")
            await asyncio.sleep(0.1)
        await asyncio.sleep(settle)

    async def figures(self, part: str, states: Callable[[], int], note: str, seconds: float) -> list[Figure]:
        """Return rate of states, CPU time and memory of the bridge, measured for a time.

        Parameters
        ----------
        part : str
            Name of what is measured.
        states : callable
            Returns the number of states of all AGVs so far.
        note : str
            Says what is counted.
        seconds : float
            The time [s].
        """
        process, before, began = psutil.Process(self._process.pid), states(), monotonic()
        share = await share_of_core(process, seconds)
        rate = (states() - before) / (monotonic() - began) / self._agvs
        limit = SHARE_LIMIT if self._agvs == MEASURED_ROBOTS else None
        return [
            Figure(part, "states of an AGV", round(rate, 2), "1/s", note=note),
            Figure(part, "share of a core", round(share, 1), "%", limit=limit),
            Figure(part, "memory", round(process.memory_info().rss / 1e6, 1), "MB"),
        ]


@asynccontextmanager
async def bridge_process(
    arguments: Sequence[str], port: int, url: str, log: Path, agvs: int
) -> AsyncIterator[BridgeProcess]:
    """Run ``ppaas bridge`` with arguments, a broker on a port of this machine, and the URL of a cloud."""
    command = [sys.executable, "-m", cli.__name__, "bridge", *arguments]
    options = ["--broker", f"mqtt://127.0.0.1:{port}", "--url", url, "--token", "none"]
    with log.open("wb") as output:
        process = await asyncio.create_subprocess_exec(*command, *options, stdout=output, stderr=output)
    try:
        yield BridgeProcess(process, agvs)
    finally:
        process.terminate()
        await asyncio.wait_for(process.wait(), 30.0)
