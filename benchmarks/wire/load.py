"""Load of laser scans at a fixed rate, and the CPU time that a program takes for each frame of it."""

import asyncio
import contextlib
import sys
import tempfile
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass
from pathlib import Path

from websockets.asyncio.client import ClientConnection

from benchmarks.wire import frame_copier
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
