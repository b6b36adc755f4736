"""Load of laser scans at a fixed rate: the CPU time that a frame takes, and the memory that idle robots take.

The baseline is a bare program with as many sockets, which copies each frame to a Unix socket.
"""

import asyncio
import contextlib
import sys
import tempfile
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path

import psutil
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection

from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.process_usage import cpu_of
from benchmarks.wire import frame_copier
from benchmarks.wire.site import Endpoints, opened, private_kb, robots, scan_frame
from ppaas.clock import monotonic

RATE = 20.0
"""Scans of each robot [Hz]."""


async def send_scans(sockets: list[ClientConnection], frame: str, seconds: float) -> int:
    """Send scans on all sockets in turn at `RATE`, evenly spread over time; return their number."""
    began, count = monotonic(), round(seconds * RATE) * len(sockets)
    for number in range(count):
        await sockets[number % len(sockets)].send(frame)
        await asyncio.sleep(max(began + (number + 1) / (RATE * len(sockets)) - monotonic(), 0.0))
    return count


@dataclass(frozen=True, slots=True)
class FrameCosts:
    """CPU time of each process for a load [s], beyond what they take without it, and the number of its frames."""

    seconds: list[float]
    frames: int

    @property
    def each(self) -> float:
        """CPU time of all processes for one frame [s]."""
        return sum(self.seconds) / self.frames


async def frame_costs(
    cpu: Callable[[], list[float]], sockets: list[ClientConnection], frame: str, seconds: float
) -> FrameCosts:
    """Return the CPU time for a load of scans.

    Parameters
    ----------
    cpu : callable
        Returns the CPU time of each process so far [s].
    sockets : list of ClientConnection
        Sockets of the robots.
    frame : str
        The frame that each sends.
    seconds : float
        Duration of the load [s]; the processes are watched without it for as long before.
    """
    before = cpu()
    await asyncio.sleep(seconds)
    idle, began = cpu(), monotonic()
    frames = await send_scans(sockets, frame, seconds)
    took, busy = monotonic() - began, cpu()
    rest = [(after - first) * took / seconds for first, after in zip(before, idle, strict=True)]
    return FrameCosts([max(end - start - at_rest, 0.0) for start, end, at_rest in zip(idle, busy, rest, strict=True)],
                      frames)  # fmt: skip


@contextlib.asynccontextmanager
async def copier() -> AsyncIterator[tuple[str, int]]:
    """Run the bare program with a reader of its Unix socket; yield its address and its process id."""

    async def discard(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        while await reader.read(1 << 16):
            continue
        writer.close()

    with tempfile.TemporaryDirectory(prefix="b-") as folder:
        path = str(Path(folder) / "sink")
        async with await asyncio.start_unix_server(discard, path, backlog=2048):
            process = await asyncio.create_subprocess_exec(
                sys.executable, "-m", frame_copier.__name__, path,
                stdin=asyncio.subprocess.PIPE, stdout=asyncio.subprocess.PIPE,
            )  # fmt: skip
            assert process.stdin is not None and process.stdout is not None
            try:
                yield f"127.0.0.1:{int(await process.stdout.readline())}", process.pid
            finally:
                process.stdin.close()
                await process.wait()


# -- CPU time of an endpoint for a laser scan --------------------------------------------------------------------------

CPU = "cpu"
ROBOTS = 20
ROUNDS, SECONDS, QUICK_SECONDS = 5, 4.0, 1.0
"""Number of loads on each program in turn, and the duration of each [s]."""

RATIO_LIMIT = 2.5
"""Largest acceptable ratio of the CPU time to the bare program's."""


async def measure_cpu(site: EngineSite, progress: Progress, quick: bool) -> list[Figure]:
    """Put the same load on the endpoint and on the bare program in turn."""
    frame, seconds, endpoints = scan_frame(), QUICK_SECONDS if quick else SECONDS, Endpoints(site)
    async with copier() as (address, pid), opened(*await robots(site, 0, ROBOTS)) as served:
        bare = psutil.Process(pid)
        async with opened(*(f"ws://{address}" for _ in range(ROBOTS))) as plain:
            taken: list[tuple[FrameCosts, FrameCosts]] = []
            for _ in progress.track(range(1 if quick else ROUNDS), description="CPU of a frame"):
                cloud = await frame_costs(endpoints.cpu, served, frame, seconds)
                taken.append((cloud, await frame_costs(lambda: [cpu_of(bare)], plain, frame, seconds)))
    return cpu_figures([(1e6 * cloud.each, 1e6 * copied.each) for cloud, copied in taken], len(endpoints.processes))


def cpu_figures(taken: list[tuple[float, float]], endpoints: int) -> list[Figure]:
    """Return the cpu_figures, from the CPU times of a frame in the endpoints and in the bare program [µs], in pairs."""
    cloud, bare = ([pair[which] for pair in taken] for which in (0, 1))
    ratios = [one / other for one, other in taken]
    load = f"{ROBOTS} robots at {RATE:g} Hz, nothing sent back; beyond what silent robots take"
    which = "of the one endpoint" if endpoints == 1 else f"of {endpoints} endpoints"
    return [
        median_of(CPU, "endpoint, a scan", cloud, "µs", note=f"CPU time {which}; {load}"),
        median_of(CPU, "uvicorn and websockets", bare, "µs", yardstick=True, note="copy the frame to a Unix socket"),
        median_of(CPU, "beside it", ratios, "x", limit=RATIO_LIMIT),
    ]


# -- memory of an endpoint for a robot that is connected and sends nothing ---------------------------------------------

MEMORY = "memory"
WARM = 50
"""Number of robots that are connected before: what the first ones load is not counted."""

IDLE_ROBOTS, QUICK_IDLE_ROBOTS = 1000, 50
IDLE_LIMIT = 60.0
"""Largest acceptable memory of an idle robot [KB]."""

SETTLING = 3.0
"""Time after the last connection before memory is read [s]."""


async def measure_memory(site: EngineSite, progress: Progress, quick: bool) -> list[Figure]:
    """Connect robots, each with its own container, and then as many sockets to the bare program."""
    count, endpoints = QUICK_IDLE_ROBOTS if quick else IDLE_ROBOTS, Endpoints(site)
    task = progress.add_task(f"{count} idle robots", total=2 * count)
    urls = await robots(site, 0, WARM + count)
    served = await _memory_of_each(urls, endpoints.memory)
    progress.advance(task, count)
    async with copier() as (address, pid):
        bare = await _memory_of_each([f"ws://{address}"] * (WARM + count), lambda: private_kb(pid))
    progress.remove_task(task)
    return memory_figures(served, bare, count, len(endpoints.processes))


async def _memory_of_each(urls: list[str], memory: Callable[[], float]) -> float:
    """Open sockets; return the memory that each beyond the first `WARM` takes [KB]."""
    async with opened(*urls[:WARM]):
        await asyncio.sleep(SETTLING)
        before = memory()
        async with opened(*urls[WARM:]) as sockets:
            await asyncio.sleep(SETTLING)
            return (memory() - before) / len(sockets)


def memory_figures(served: float, bare: float, count: int, endpoints: int) -> list[Figure]:
    """Return the memory_figures of the memory of each of ``count`` sockets [KB]."""
    which = "of the one endpoint" if endpoints == 1 else f"of {endpoints} endpoints"
    note = f"private memory {which}; {count:,} robots, each with its container, that send nothing"
    return [
        Figure(MEMORY, "idle robot", round(served, 1), "KB", limit=IDLE_LIMIT, note=note),
        Figure(MEMORY, "uvicorn and websockets, a socket", round(bare, 1), "KB", yardstick=True,
               note="with its connection to a Unix socket"),
    ]  # fmt: skip
