"""Cloud of the wire bench, its robots, and the processes that serve their sockets."""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator
from urllib.parse import urlsplit

import psutil
from websockets.asyncio.client import ClientConnection, connect

from benchmarks.engine.driving_robot import grid_to_drive_on
from benchmarks.engine.options import EngineOptions
from benchmarks.engine.site import EngineSite, LocalHosts, cloud_on
from benchmarks.harness.cloud_under_test import CORES
from benchmarks.harness.process_usage import cpu_of, memory_of
from engine.specs.machine_settings import MOST_OVERSUBSCRIPTION
from ppaas.geometry import Pose2D
from ppaas.messages.base.std_msgs import Header
from ppaas.messages.sensor_msgs import LaserScan
from ppaas.wire.rosbridge_client import RosbridgeClientSession

MAP = "bench-wire"
RUNTIME = "bench-echo"
ALLOWED = ("--runtime", RUNTIME, "--allow", f"ppaas.runtimes:{RUNTIME}")
"""Arguments of ``ppaas up`` for containers that answer each scan with a velocity."""

BEAMS = 360
START = Pose2D(1.0, 1.0, 0.0)

AT_ONCE = 20
"""Number of robots that connect at once."""


def scan_frame() -> str:
    """Return the frame of rosbridge with a laser scan of `BEAMS` beams, with millimetres and intensities."""
    ranges: list[float | None] = [round(2.0 + math.sin(beam / 20.0), 3) for beam in range(BEAMS)]
    scan = LaserScan(
        header=Header(frame_id="base_scan"),
        angle_min=-math.pi,
        angle_max=math.pi,
        angle_increment=math.tau / BEAMS,
        scan_time=0.1,
        range_min=0.12,
        range_max=8.0,
        ranges=ranges,
        intensities=[10.0 + 7 * beam % 80 for beam in range(BEAMS)],
    )
    return RosbridgeClientSession().publish("scan", scan)


@contextlib.asynccontextmanager
async def echo_cloud(robots: int, *more: str) -> AsyncIterator[EngineSite]:
    """Start a cloud whose machine takes a number of robots, with further arguments of ``ppaas up``."""
    options = EngineOptions(containers=robots)
    async with cloud_on(LocalHosts((*ALLOWED, *more)), options) as site:
        await site.limit(site.machine, max_containers=robots, oversubscription=MOST_OVERSUBSCRIPTION)
        await site.target.publish(MAP, grid_to_drive_on())
        yield site


@contextlib.asynccontextmanager
async def opened(*urls: str) -> AsyncIterator[list[ClientConnection]]:
    """Open WebSockets, some at once, and close all of them afterwards."""
    async with contextlib.AsyncExitStack() as stack:
        sockets: list[ClientConnection] = []
        for first in range(0, len(urls), AT_ONCE):
            several = (connect(url, compression=None, open_timeout=60.0) for url in urls[first : first + AT_ONCE])
            sockets += await asyncio.gather(*map(stack.enter_async_context, several))
        yield sockets


async def robots(site: EngineSite, first: int, count: int) -> list[str]:
    """Register robots by their numbers; return the URLs of their WebSockets."""
    names = [f"bench-{number}" for number in range(first, first + count)]
    return [await site.target.register(name, MAP, (START.x, START.y, START.theta), CORES) for name in names]


class Endpoints:
    """The processes that serve robots' sockets: those of the cloud that listen on its port.

    Parameters
    ----------
    site : EngineSite
        The cloud.
    """

    def __init__(self, site: EngineSite) -> None:
        assert site.target.pid is not None
        started, port = psutil.Process(site.target.pid), urlsplit(site.target.url).port
        every = [started, *started.children(recursive=True)]
        self.processes = [process for process in every if port in _listened(process)]
        self.others = [process for process in every if process not in self.processes]

    def cpu(self) -> list[float]:
        """Return the CPU time of each endpoint so far [s]."""
        return [cpu_of(process) for process in self.processes]

    def memory(self) -> float:
        """Return the private memory of all endpoints [KB]."""
        return sum(private_kb(process.pid) for process in self.processes)


def _listened(process: psutil.Process) -> set[int]:
    """Return the ports on which a process accepts connections."""
    try:
        found = process.net_connections("tcp")
    except psutil.Error:  # it has just exited
        return set()
    return {each.laddr.port for each in found if each.status == psutil.CONN_LISTEN}


def private_kb(pid: int) -> float:
    """Return the private memory of a process [KB]."""
    return 1e3 * memory_of(pid).private
