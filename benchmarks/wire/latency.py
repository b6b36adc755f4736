"""Added latency: a laser scan to the container of its robot, and a velocity back, beside an echo of the same frame."""

import time
from collections.abc import Awaitable, Callable

import msgspec
import numpy as np
from rich.progress import Progress
from websockets.asyncio.client import ClientConnection

from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure, median_and_p99
from benchmarks.service.plan_requests import echo
from benchmarks.wire.site import opened, robots, scan_frame

PART = "latency"
SAMPLES, QUICK = 2000, 50
WARM = 50
"""Number of samples that are not counted."""

ADDED_LIMIT = 0.5
"""Largest acceptable median of the added latency [ms]."""

Exchange = Callable[[], Awaitable[None]]


async def measure(site: EngineSite, progress: Progress, quick: bool) -> list[Figure]:
    """Send a scan to the cloud and to an echo server in turn, repeatedly."""
    frame = scan_frame()
    async with opened(*await robots(site, 0, 1)) as [robot]:
        await robot.send('{"op":"subscribe","topic":"cmd_vel"}')
        size = await _first_answer(robot, frame)
        async with echo("websockets", size) as server, opened(f"ws://{server.address}") as [plain]:
            ways: dict[str, Exchange] = {
                "cloud": lambda: _exchange(robot, frame),
                "echo": lambda: _exchange(plain, frame),
            }
            samples = await _sample(ways, QUICK if quick else SAMPLES, progress)
    return figures(samples["cloud"], samples["echo"], len(frame), size)


async def _first_answer(robot: ClientConnection, frame: str) -> int:
    """Send a scan; return the size of the velocity that answers it [bytes]."""
    await robot.send(frame)
    return len(await robot.recv(decode=False))


async def _exchange(socket: ClientConnection, frame: str) -> None:
    await socket.send(frame)
    await socket.recv(decode=False)


async def _sample(ways: dict[str, Exchange], count: int, progress: Progress) -> dict[str, list[float]]:
    samples: dict[str, list[float]] = {name: [] for name in ways}
    for number in progress.track(range(WARM + count), description="latency"):
        for name, exchange in ways.items():
            began = time.perf_counter()
            await exchange()
            if number >= WARM:
                samples[name].append(time.perf_counter() - began)
    return samples


def figures(cloud: list[float], plain: list[float], sent: int, answered: int) -> list[Figure]:
    """Return the figures.

    Parameters
    ----------
    cloud, plain : list of float
        Times until the answer, through the cloud and by the echo server [s].
    sent, answered : int
        Sizes of the frame and of its answer [bytes].
    """
    (cloud_median, cloud_p99), (plain_median, plain_p99) = (
        1e3 * np.percentile(each, (50, 99)) for each in (cloud, plain)
    )
    what = f"scan of {sent:,} bytes, cmd_vel of {answered} back"
    bare = median_and_p99(PART, "websockets, echo", plain, note="the same frame, an answer of that size")
    return [
        *median_and_p99(PART, "endpoint and container", cloud, note=what),
        *(msgspec.structs.replace(figure, yardstick=True) for figure in bare),
        Figure(PART, "added", round(float(cloud_median - plain_median), 3), "ms", limit=ADDED_LIMIT,
               note="difference of the medians"),
        Figure(PART, "added, p99", round(float(cloud_p99 - plain_p99), 3), "ms", note="difference of the p99"),
    ]  # fmt: skip
