"""Runs the parts of the engine bench."""

import contextlib
from collections.abc import AsyncIterator, Awaitable, Callable

from rich.progress import Progress

from benchmarks.engine import capacity, first_answer, master, messages, people_coordinator, recovery, standby
from benchmarks.engine.options import EngineOptions
from benchmarks.engine.ray_cluster import ray_hosts
from benchmarks.engine.site import EngineSite, Hosts, LocalHosts, cloud_on
from benchmarks.harness.figures import Figure

Measure = Callable[[EngineSite, EngineOptions, Progress], Awaitable[list[Figure]]]

PARTS: dict[str, Measure] = {
    first_answer.PART: first_answer.measure,
    capacity.PART: capacity.measure,
    recovery.CRASH: recovery.measure_crashes,
    recovery.LOSS: recovery.measure_losses,
    messages.PART: messages.measure,
    people_coordinator.PART: people_coordinator.measure,
}
"""Parts that need a running cloud; the parts ``standby`` and ``master`` need none."""


async def measure(options: EngineOptions, progress: Progress) -> list[Figure]:
    """Measure the parts one after the other.

    Raises
    ------
    PPaaSError
        A cloud does not start, or refuses something.
    """
    figures: list[Figure] = []
    wanted = [measure_part for part, measure_part in PARTS.items() if options.wants(part)]
    if wanted:
        async with _hosts(options) as hosts, cloud_on(hosts, options) as site:
            for measure_part in wanted:
                figures += await measure_part(site, options, progress)
    if options.wants(standby.PART):
        figures += await standby.measure(options, progress)
    if options.wants(master.PART):
        figures += await master.measure(options, progress)
    return figures


@contextlib.asynccontextmanager
async def _hosts(options: EngineOptions) -> AsyncIterator[Hosts]:
    if options.runtime == "ray":
        async with ray_hosts() as hosts:
            yield hosts
    else:
        yield LocalHosts(("--runtime", options.runtime))
