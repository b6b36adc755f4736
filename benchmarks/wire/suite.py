"""Runs the parts of the wire bench."""

from collections.abc import Awaitable, Callable

from rich.progress import Progress

from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure
from benchmarks.harness.parts import PartSelection
from benchmarks.wire import frame_cpu, half_open, idle_memory, latency, two_endpoints
from benchmarks.wire.site import echo_cloud

Measure = Callable[[EngineSite, Progress, bool], Awaitable[list[Figure]]]

PARTS: dict[str, Measure] = {
    latency.PART: latency.measure,
    frame_cpu.PART: frame_cpu.measure,
    idle_memory.PART: idle_memory.measure,
    half_open.PART: half_open.measure,
}
"""Parts that need a running cloud; the part ``endpoints`` starts its own."""

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
        async with echo_cloud(idle_memory.WARM + idle_memory.ROBOTS + SPARE) as site:
            for measure_part in wanted:
                figures += await measure_part(site, progress, options.quick)
    if options.wants(two_endpoints.PART):
        figures += await two_endpoints.measure(progress, options.quick)
    return figures
