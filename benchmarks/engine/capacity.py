"""Capacity of a machine: opens many robots at once, requests a path from each, and measures memory."""

import asyncio
import contextlib
import math
import os

from rich.progress import Progress
from websockets.asyncio.client import ClientConnection

from benchmarks.engine import baselines
from benchmarks.engine.first_answer import MAP, FirstPathQuestion, opened, prepared
from benchmarks.engine.options import EngineOptions
from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure, median_of
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError
from robots.client.cloud_url import path_of

PART = "crowd"
CORES = 0.25
"""Size of a container [cores]."""

FEW = 3
"""Number of containers of a quick run."""
WEIGHED_TIMEOUT = 30.0
"""Time within which the machine reports the memory of each container [s]."""

ROBOT = "bench-crowd-"


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Oversubscribe the machine for the wanted number of containers; then open all robots at once."""
    wanted = min(options.containers, FEW) if options.quick else options.containers
    question = await prepared(site.target)
    before = await site.target.rest.get(path_of("machines", site.machine))
    oversubscription = max(math.ceil(wanted * CORES / before["cores"]), before["oversubscription"])
    await site.limit(site.machine, max_containers=wanted, oversubscription=oversubscription)
    try:
        return await _crowd(site, question, wanted, progress)
    finally:
        told = {name: before[name] for name in ("max_containers", "oversubscription")}
        await site.limit(site.machine, **told)


async def _crowd(site: EngineSite, question: FirstPathQuestion, wanted: int, progress: Progress) -> list[Figure]:
    urls = [await site.target.register(f"{ROBOT}{n}", MAP, question.start, CORES) for n in range(wanted)]
    task = progress.add_task(f"{wanted} containers at a time", total=wanted)
    async with contextlib.AsyncExitStack() as stack:
        began = monotonic()

        async def open_one(url: str) -> tuple[ClientConnection, float] | str:
            try:
                socket = await stack.enter_async_context(opened(url))
                await question.ask(socket)
            except PPaaSError as error:
                return str(error)
            progress.advance(task)
            return socket, monotonic() - began

        came = await asyncio.gather(*(open_one(url) for url in urls))
        progress.remove_task(task)
        stopped = [why for why in came if isinstance(why, str)]
        ready = [one for one in came if not isinstance(one, str)]
        again = [await _asked(question, socket) for socket, _ in ready]
        weights = await _weights(site, len(ready))
    figures = capacity_figures(wanted, [seconds for _, seconds in ready], stopped, again, weights)
    return [*figures, await _pythons(wanted)]


async def _pythons(count: int) -> Figure:
    began = monotonic()
    await asyncio.gather(*(baselines.python() for _ in range(count)))
    took = round(monotonic() - began, 3)
    return Figure(PART, "python -c pass, as many", took, "s", yardstick=True, note="bare interpreters, all at once")


async def _asked(question: FirstPathQuestion, socket: ClientConnection) -> float:
    began = monotonic()
    await question.ask(socket)
    return monotonic() - began


async def _weights(site: EngineSite, containers: int) -> list[int]:
    """Return the proportional set size of each container as reported by its machine [bytes]; fewer after a timeout."""
    deadline = monotonic() + WEIGHED_TIMEOUT
    while True:
        weights = [view["pss"] for view in await site.containers(ROBOT) if view["pss"]]
        if len(weights) >= containers or monotonic() > deadline:
            return weights
        await asyncio.sleep(0.5)


def capacity_figures(
    wanted: int, ready: list[float], stopped: list[str], again: list[float], weights: list[int]
) -> list[Figure]:
    """Return the figures of the capacity bench.

    Parameters
    ----------
    wanted : int
        Number of robots that were opened.
    ready : list of float
        Time until each container answered, for those that did [s].
    stopped : list of str
        Errors of the others.
    again : list of float
        Time of a second answer of each container [s].
    weights : list of int
        Proportional set size of each container [bytes].
    """
    why = f"what stopped the next: {stopped[0]}" if stopped else f"of {CORES:g} cores each, opened at once"
    figures = [Figure(PART, "containers that answer", len(ready), "containers", limit=wanted, floor=True, note=why)]
    if ready:
        figures += [
            Figure(PART, "until all have answered", round(max(ready), 3), "s", note=f"on {os.cpu_count()} CPUs"),
            median_of(PART, "each, from the first opened on", ready, note="a path from each, all asked at once"),
            median_of(PART, "each asked again", again, note="a path, one after the other, while all others are there"),
        ]
    if weights:
        each = [weight / 1e6 for weight in weights]
        figures.append(median_of(PART, "memory of each", each, "MB", note="PSS, the shared map included"))
        figures.append(Figure(PART, "memory of all", round(sum(each), 1), "MB", note=f"of {len(each)} containers"))
    return figures
