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
from benchmarks.vda5050.fleet_stand_in import MAP, fleet_stand_in
from ppaas.clock import epoch, monotonic
from ppaas.errors import InvalidInput, Unavailable
from ppaas.wire.vda5050 import topics
from ppaas.wire.vda5050.codec import encode
from ppaas.wire.vda5050.headers import HeaderCounter
from ppaas.wire.vda5050.orders import Deviation, Edge, Node, NodePosition, Order
from ppaas.wire.vda5050.topics import Address
from ppaas.wire.vda5050.versions import Version
from robots import cli

if TYPE_CHECKING:
    from rich.progress import Progress

START_TIMEOUT = 60.0
"""Time within which all AGVs report [s]."""

SETTLE = 5.0
"""Time after which start and orders are over [s]."""

SHARE_LIMIT = 10.0
"""Largest share of a core for 200 AGVs [%]."""

MEASURED_ROBOTS = 200
"""Number of AGVs that the limit is for."""

ORDER = Order(
    order_id="far",
    order_update_id=0,
    nodes=[
        Node(
            node_id=f"n{index}",
            sequence_id=2 * index,
            released=True,
            actions=[],
            node_position=NodePosition(
                x=50.0 * index, y=0.0, map_id=MAP, allowed_deviation_xy=Deviation(a=2.0, b=2.0, theta=0.0)
            ),
        )
        for index in range(2)
    ],
    edges=[Edge(edge_id="e", sequence_id=1, released=True, actions=[], start_node_id="n0", end_node_id="n1")],
)
"""Order from where the robots are to a node that they do not reach."""


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
        async with broker(Path(folder)) as port, fleet_stand_in() as url, _states(port) as arrived:
            names = [f"r{index}" for index in range(robots)]
            bridge = _start(names, port, url, Path(folder) / "bridge.log")
            try:
                await _all_report(bridge, arrived, robots)
                progress.advance(task)
                figures = await _measured("stand", bridge, arrived, robots, seconds)
                await _order_all(names, port)
                await asyncio.sleep(SETTLE)
                figures += await _measured("drive", bridge, arrived, robots, seconds)
                progress.advance(task)
            finally:
                bridge.terminate()
                await asyncio.to_thread(bridge.wait, 30)
    return figures


async def _order_all(names: list[str], port: int) -> None:
    """Order each AGV to a node that it does not reach."""
    async with Client("127.0.0.1", port) as client:
        for name in names:
            address = Address.of(Version.V2_1, "ppaas", name)
            header = HeaderCounter(Version.V2_1, address).next(topics.ORDER, epoch())
            await client.publish(address.topic(topics.ORDER), encode(topics.ORDER, header, ORDER, Version.V2_1))


async def _measured(
    doing: str, bridge: subprocess.Popen[bytes], arrived: "Counter[str]", robots: int, seconds: float
) -> list[Figure]:
    process = psutil.Process(bridge.pid)
    before, since, spent = arrived.total(), monotonic(), sum(process.cpu_times()[:2])
    await asyncio.sleep(seconds)
    passed = monotonic() - since
    share = 100.0 * (sum(process.cpu_times()[:2]) - spent) / passed
    states = (arrived.total() - before) / passed / robots
    part, limit = f"{robots} AGVs that {doing}", SHARE_LIMIT if robots == MEASURED_ROBOTS else None
    return [
        Figure(part, "states of an AGV", round(states, 2), "1/s", note="that arrived at a master control"),
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
    await asyncio.sleep(SETTLE)


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
async def broker(folder: Path) -> AsyncIterator[int]:
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
