"""Programs of a bench that run beside it."""

import asyncio
import subprocess
import sys
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import psutil

from benchmarks.harness.process_usage import cpu_of
from ppaas.clock import monotonic


@asynccontextmanager
async def running(*words: str) -> AsyncIterator[psutil.Process]:
    """Run Python with words for the time of a block."""
    command: Sequence[str] = [sys.executable, *words]
    process = await asyncio.to_thread(subprocess.Popen, command, stdin=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield psutil.Process(process.pid)
    finally:
        process.terminate()
        await asyncio.to_thread(process.wait)


async def share_of_core(process: psutil.Process, seconds: float) -> float:
    """Return the share of a core that a process takes for some seconds [%]."""
    used, began = cpu_of(process), monotonic()
    await asyncio.sleep(seconds)
    return 100.0 * (cpu_of(process) - used) / (monotonic() - began)
