"""Cost of a bridge of a rover with MAVLink, whose messages come ten times a second, beside pymavlink's bare station."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import psutil

from benchmarks.bridge import bare_station
from benchmarks.bridge.measurement import MOST_CPU, MOST_MEMORY, CloudStandIn, cloud_stand_in
from benchmarks.bridge.processes import running, share_of_core
from benchmarks.harness.figures import Figure
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.process_usage import cpu_of
from ppaas.clock import monotonic
from robots import cli
from robots.sim import mavlink

PART = "bridge mavlink"
SECONDS, QUICK_SECONDS = 20.0, 2.0
"""Time for which CPU time is counted [s]."""

PERIOD = 0.1
"""Time between two velocities [s]."""

SETTLE = 4.0
"""Time until a station has found the rover and driven off [s]."""


async def measure_rover(*, quick: bool) -> list[Figure]:
    """Return the figures."""
    seconds = QUICK_SECONDS if quick else SECONDS
    bare = await _bare(seconds)
    async with cloud_stand_in() as cloud:
        share, memory, poses = await _bridge(cloud, seconds)
    return [
        Figure(PART, "share of a core, pymavlink alone", round(bare, 2), "%", yardstick=True, note="the same messages"),
        Figure(PART, "share of a core", round(share, 2), "%", limit=MOST_CPU, note="setpoints and poses at 10 Hz"),
        Figure(PART, "memory", round(memory, 1), "MB", limit=MOST_MEMORY),
        Figure(PART, "poses at the cloud", round(poses, 1), "Hz"),
    ]


async def _bare(seconds: float) -> float:
    (port,) = free_ports(1)
    async with running("-m", bare_station.__name__, f"udpin:127.0.0.1:{port}") as station, _rover(port):
        await asyncio.sleep(SETTLE)
        return await share_of_core(station, seconds)


async def _bridge(cloud: CloudStandIn, seconds: float) -> tuple[float, float, float]:
    """Return the share of a core [%], the memory [MB] and the rate of poses [Hz]."""
    (port,) = free_ports(1)
    words = ["--robot", "robot", "--vehicle", f"udpin:127.0.0.1:{port}", "--anchor=47.4,8.5", "--system", "1"]
    command = ["-m", cli.__name__, "bridge", "mavlink", *words, "--url", cloud.url, "--token", "t"]
    twist = {"linear": {"x": 0.1}, "angular": {"z": 0.1}}
    async with running(*command) as bridge, _rover(port):
        await cloud.publish("cmd_vel", twist)
        for _ in range(round(SETTLE / PERIOD)):
            await cloud.publish("cmd_vel", twist)
            await asyncio.sleep(PERIOD)
        used, began, poses = cpu_of(bridge), monotonic(), len(cloud.arrived["odom"])
        while monotonic() - began < seconds:
            await cloud.publish("cmd_vel", twist)
            await asyncio.sleep(PERIOD)
        passed = monotonic() - began
        share, rate = 100.0 * (cpu_of(bridge) - used) / passed, (len(cloud.arrived["odom"]) - poses) / passed
        return share, bridge.memory_info().rss / 1e6, rate


@asynccontextmanager
async def _rover(port: int) -> AsyncIterator[psutil.Process]:
    words = ["--station", f"udpout:127.0.0.1:{port}", "--latitude", "47.4", "--longitude", "8.5", "--armed"]
    async with running("-m", mavlink.__name__, *words) as process:
        yield process
