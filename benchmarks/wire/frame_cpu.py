"""CPU time of an endpoint for a laser scan, beside a bare program that copies the frame to a Unix socket."""

import psutil
from rich.progress import Progress

from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.process_usage import cpu_of
from benchmarks.wire.load import RATE, FrameCosts, copier, frame_costs
from benchmarks.wire.site import Endpoints, opened, robots, scan_frame

PART = "cpu"
ROBOTS = 20
ROUNDS, SECONDS, QUICK_SECONDS = 5, 4.0, 1.0
"""Number of loads on each program in turn, and the duration of each [s]."""

RATIO_LIMIT = 2.5
"""Largest acceptable CPU time beside that of the bare program."""


async def measure(site: EngineSite, progress: Progress, quick: bool) -> list[Figure]:
    """Put the same load on the endpoint and on the bare program in turn."""
    frame, seconds, endpoints = scan_frame(), QUICK_SECONDS if quick else SECONDS, Endpoints(site)
    async with copier() as (address, pid), opened(*await robots(site, 0, ROBOTS)) as served:
        bare = psutil.Process(pid)
        async with opened(*(f"ws://{address}" for _ in range(ROBOTS))) as plain:
            taken: list[tuple[FrameCosts, FrameCosts]] = []
            for _ in progress.track(range(1 if quick else ROUNDS), description="CPU of a frame"):
                cloud = await frame_costs(endpoints.cpu, served, frame, seconds)
                taken.append((cloud, await frame_costs(lambda: [cpu_of(bare)], plain, frame, seconds)))
    return figures([(1e6 * cloud.each, 1e6 * copied.each) for cloud, copied in taken], len(endpoints.processes))


def figures(taken: list[tuple[float, float]], endpoints: int) -> list[Figure]:
    """Return the figures, from the CPU times of a frame in the endpoints and in the bare program [µs], in pairs."""
    cloud, bare = ([pair[which] for pair in taken] for which in (0, 1))
    ratios = [one / other for one, other in taken]
    load = f"{ROBOTS} robots at {RATE:g} Hz, nothing sent back; beyond what silent robots take"
    which = "of the one endpoint" if endpoints == 1 else f"of {endpoints} endpoints"
    return [
        median_of(PART, "endpoint, a scan", cloud, "µs", note=f"CPU time {which}; {load}"),
        median_of(PART, "uvicorn and websockets", bare, "µs", yardstick=True, note="copy the frame to a Unix socket"),
        median_of(PART, "beside it", ratios, "x", limit=RATIO_LIMIT),
    ]
