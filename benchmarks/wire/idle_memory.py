"""Memory of an endpoint for a robot that is connected and sends nothing, beside a bare program with as many sockets."""

import asyncio
from collections.abc import Callable

from rich.progress import Progress

from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure
from benchmarks.wire.load import copier
from benchmarks.wire.site import Endpoints, opened, private_kb, robots

PART = "memory"
WARM = 50
"""Number of robots that are connected before: what the first ones load is not counted."""

ROBOTS, QUICK = 1000, 50
IDLE_LIMIT = 60.0
"""Largest acceptable memory of an idle robot [KB]."""

SETTLING = 3.0
"""Time after the last connection before memory is read [s]."""


async def measure(site: EngineSite, progress: Progress, quick: bool) -> list[Figure]:
    """Connect robots, each with its own container, and then as many sockets to the bare program."""
    count, endpoints = QUICK if quick else ROBOTS, Endpoints(site)
    task = progress.add_task(f"{count} idle robots", total=2 * count)
    urls = await robots(site, 0, WARM + count)
    served = await _memory_of_each(urls, endpoints.memory)
    progress.advance(task, count)
    async with copier() as (address, pid):
        bare = await _memory_of_each([f"ws://{address}"] * (WARM + count), lambda: private_kb(pid))
    progress.remove_task(task)
    return figures(served, bare, count, len(endpoints.processes))


async def _memory_of_each(urls: list[str], memory: Callable[[], float]) -> float:
    """Open sockets; return the memory that each beyond the first `WARM` takes [KB]."""
    async with opened(*urls[:WARM]):
        await asyncio.sleep(SETTLING)
        before = memory()
        async with opened(*urls[WARM:]) as sockets:
            await asyncio.sleep(SETTLING)
            return (memory() - before) / len(sockets)


def figures(served: float, bare: float, count: int, endpoints: int) -> list[Figure]:
    """Return the figures of the memory of each of ``count`` sockets [KB]."""
    which = "of the one endpoint" if endpoints == 1 else f"of {endpoints} endpoints"
    note = f"private memory {which}; {count:,} robots, each with its container, that send nothing"
    return [
        Figure(PART, "idle robot", round(served, 1), "KB", limit=IDLE_LIMIT, note=note),
        Figure(PART, "uvicorn and websockets, a socket", round(bare, 1), "KB", yardstick=True,
               note="with its connection to a Unix socket"),
    ]  # fmt: skip
