"""Start of a container: time from opening an authenticated WebSocket to the clone's first message."""

from rich.progress import Progress
from websockets.asyncio.client import connect

from benchmarks.harness.cloud_under_test import Target
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from ppaas.maps.generate import warehouse
from robots.sim.courses import CoursePlanner

PART = "containers"
MAP = "bench-containers"
OPENS, QUICK = 20, 5

LIMIT_MS = 100.0

FIRST_MESSAGE = '{"op":"subscribe","topic":"tf_static"}'
"""Subscription to a latched topic, which the clone answers at once."""


async def measure(target: Target, progress: Progress, quick: bool) -> list[Figure]:
    """Open robots one after the other; the first is a warm-up, as the map is new to the machine."""
    grid = warehouse(seed=1)
    start = CoursePlanner(grid, 1).choose(1, 1)[0].start
    await target.publish(MAP, grid)
    ready = []
    for number in progress.track(range((QUICK if quick else OPENS) + 1), description="opening robots"):
        url = await target.register(f"bench-open-{number}", MAP, start)
        ready.append(await _open(url))
    note = "from opening the socket to the first message of the clone"
    return [median_of(PART, "container ready", ready[1:], limit=LIMIT_MS, note=note)]


async def _open(url: str) -> float:
    began = monotonic()
    async with connect(url, max_size=None) as socket:
        await socket.send(FIRST_MESSAGE)
        await socket.recv()
        return monotonic() - began
