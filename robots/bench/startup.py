"""How long a user waits for the command and for a cloud."""

import asyncio
import sys

from rich.progress import Progress

from ppaas.clock import monotonic
from robots.bench.figures import Figure, median_of
from robots.cloud_process import CloudProcess

PART = "startup"
RUNS, QUICK = 10, 2
CLOUDS = 3

HELP_LIMIT_MS = 200.0
UP_LIMIT_MS = 3000.0

NOTHING = (sys.executable, "-c", "pass")
HELP = (sys.executable, "-m", "endpoints.cli", "--help")


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Run the command for its help, and start clouds whose kernels are compiled already."""
    bare, helped = [], []
    for _ in progress.track(range(QUICK if quick else RUNS), description="ppaas --help"):
        bare.append(await _run(*NOTHING))
        helped.append(await _run(*HELP))
    ups = [await _up() for _ in progress.track(range(1 if quick else CLOUDS), description="ppaas up")]
    return [
        median_of(PART, "ppaas --help", helped, limit=HELP_LIMIT_MS),
        median_of(PART, "python -c pass", bare, yardstick=True),
        median_of(PART, "ppaas up, ready", ups, limit=UP_LIMIT_MS, note="a fresh data folder, kernels in the cache"),
    ]


async def _run(*command: str) -> float:
    began = monotonic()
    process = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.DEVNULL)
    await process.wait()
    return monotonic() - began


async def _up() -> float:
    began = monotonic()
    async with CloudProcess():
        return monotonic() - began
