"""Startup times of the command, of a cloud, and of a container until the clone's first message."""

import asyncio
import sys
import tempfile
from collections.abc import Mapping

from rich.progress import Progress
from websockets.asyncio.client import connect

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from ppaas.maps.generate import warehouse
from robots import cli
from robots.demo.cloud_process import CloudProcess
from robots.sim.courses import CoursePlanner

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
    task = progress.add_task("ppaas up, kernels to be compiled", total=None)
    with tempfile.TemporaryDirectory() as cache:
        seconds = await _up({"NUMBA_CACHE_DIR": cache})
    progress.remove_task(task)
    return Figure(PART, "ppaas up, the first on a computer", round(seconds, 1), "s", note="compiles the kernels")


# -- start of a container ----------------------------------------------------------------------------------------------

CONTAINERS = "containers"
CONTAINER_MAP = "bench-containers"
OPENS, QUICK_OPENS = 20, 5

CONTAINER_LIMIT_MS = 100.0

FIRST_MESSAGE = '{"op":"subscribe","topic":"tf_static"}'
"""Subscription to a latched topic, which the clone answers at once."""


async def measure_containers(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Open robots one after the other; the first is a warm-up, as the map is new to the machine."""
    grid = warehouse(seed=1)
    start = CoursePlanner(grid, 1).choose(1, 1)[0].start
    await target.publish(CONTAINER_MAP, grid)
    ready = []
    for number in progress.track(range((QUICK_OPENS if quick else OPENS) + 1), description="opening robots"):
        url = await target.register(f"bench-open-{number}", CONTAINER_MAP, start)
        ready.append(await _open(url))
    note = "from opening the socket to the first message of the clone"
    return [median_of(CONTAINERS, "container ready", ready[1:], limit=CONTAINER_LIMIT_MS, note=note)]


async def _open(url: str) -> float:
    began = monotonic()
    async with connect(url, max_size=None) as socket:
        await socket.send(FIRST_MESSAGE)
        await socket.recv()
        return monotonic() - began
