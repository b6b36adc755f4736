"""Runs the parts of the wire bench."""

from collections.abc import Awaitable, Callable

from rich.progress import Progress

from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure, PartSelection
from benchmarks.wire import half_open, latency, load, stop, two_endpoints
from benchmarks.wire.site import echo_cloud

Measure = Callable[[EngineSite, Progress, bool], Awaitable[list[Figure]]]

PARTS: dict[str, Measure] = {
    latency.PART: latency.measure,
    load.CPU: load.measure_cpu,
    load.MEMORY: load.measure_memory,
    half_open.PART: half_open.measure,
}
"""Parts that need a running cloud; the parts ``endpoints`` and ``stop`` start their own."""

SPARE = 10
"""Number of containers beyond those of the largest part."""


async def measure(options: PartSelection, progress: Progress) -> list[Figure]:
    """Measure the parts one after the other.

    Raises
    ------
    PPaaSError
        A cloud does not start, or refuses something.
    """
    figures: list[Figure] = []
    wanted = [measure_part for part, measure_part in PARTS.items() if options.wants(part)]
    if wanted:
        async with echo_cloud(load.WARM + load.IDLE_ROBOTS + SPARE) as site:
            for measure_part in wanted:
                figures += await measure_part(site, progress, options.quick)
    if options.wants(two_endpoints.PART):
        figures += await two_endpoints.measure(progress, options.quick)
    if options.wants(stop.PART):
        figures += await stop.measure(progress, options.quick)
    return figures
