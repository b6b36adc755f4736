"""Startup times of the command and of a cloud."""

import asyncio
import sys
import tempfile
from collections.abc import Mapping

from rich.progress import Progress

from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from robots import cli
from robots.demo.cloud_process import CloudProcess

PART = "startup"
RUNS, QUICK = 10, 2
CLOUDS = 3

HELP_LIMIT_MS = 200.0
UP_LIMIT_MS = 3000.0

NOTHING = (sys.executable, "-c", "pass")
HELP = (sys.executable, "-m", cli.__name__, "--help")


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Measure ``ppaas --help``, and the start of clouds with cached kernels and, unless quick, without."""
    bare, helped = [], []
    for _ in progress.track(range(QUICK if quick else RUNS), description="ppaas --help"):
        bare.append(await _run(*NOTHING))
        helped.append(await _run(*HELP))
    first = [] if quick else [await _first_up(progress)]
    ups = [await _up() for _ in progress.track(range(1 if quick else CLOUDS + 1), description="ppaas up")]
    return [
        *first,
        median_of(PART, "ppaas --help", helped, limit=HELP_LIMIT_MS),
        median_of(PART, "python -c pass", bare, yardstick=True),
        median_of(
            PART, "ppaas up, ready", ups[-CLOUDS:], limit=UP_LIMIT_MS, note="a fresh data folder, kernels in the cache"
        ),
    ]


async def _run(*command: str) -> float:
    began = monotonic()
    process = await asyncio.create_subprocess_exec(*command, stdout=asyncio.subprocess.DEVNULL)
    await process.wait()
    return monotonic() - began


async def _up(environment: Mapping[str, str] | None = None) -> float:
    began = monotonic()
    async with CloudProcess(environment=environment):
        return monotonic() - began


async def _first_up(progress: Progress) -> Figure:
    """Start a cloud with an empty cache of kernels."""
    task = progress.add_task("ppaas up, kernels to be compiled", total=None)
    with tempfile.TemporaryDirectory() as cache:
        seconds = await _up({"NUMBA_CACHE_DIR": cache})
    progress.remove_task(task)
    return Figure(PART, "ppaas up, the first on a computer", round(seconds, 1), "s", note="compiles the kernels")
