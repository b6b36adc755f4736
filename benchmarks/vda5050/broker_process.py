"""Mosquitto on a port of this machine."""

import asyncio
import os
import shutil
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from aiomqtt import Client, MqttError

from benchmarks.harness.free_ports import free_ports
from ppaas.clock import monotonic
from ppaas.errors import InvalidInput

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
