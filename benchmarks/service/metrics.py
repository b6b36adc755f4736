"""Costs of metrics and logs: scrapes of a cloud with many robots, and the CPU time of a fleet with and without."""

import asyncio
import contextlib
import statistics
import urllib.request
from collections.abc import AsyncIterator, Awaitable

import websockets
from rich.progress import Progress

from benchmarks.harness.cloud_under_test import LINGER, CloudUnderTest, logged_in
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.free_ports import free_ports
from benchmarks.harness.process_usage import cpu_seconds
from benchmarks.service import fleet
from ppaas.clock import monotonic
from ppaas.maps.generate import warehouse
from robots.demo.cloud_process import CloudProcess

PART = "metrics"
ROBOTS, QUICK_ROBOTS = 50, 2
"""Numbers of robots of the cloud that is scraped; they are connected, and stand."""

SCRAPES, QUICK_SCRAPES = 200, 5

IDLE = 10.0
"""Time for which the cloud is watched without scrapes, whose CPU time does not count for them [s]."""

INTERVAL = 15.0
"""Time between two scrapes of Prometheus [s]."""

SCRAPE_LIMIT = 50.0
"""Largest acceptable time of a scrape [ms]."""

SHARE_LIMIT = 0.5
"""Largest acceptable share of a core for a scrape each `INTERVAL` [%]."""

COST_LIMIT = 2.0
"""Largest acceptable growth of the CPU time of a cloud whose robots drive [%]."""

DRIVING, TURNS = 6, 4
"""Number of robots that drive, and of turns with and without metrics and logs."""


async def measure(progress: Progress, quick: bool) -> list[Figure]:
    """Measure the scrapes, then the costs."""
    return [*await _scrapes(progress, quick), *await _costs(progress, quick)]


@contextlib.asynccontextmanager
async def _cloud(*arguments: str) -> AsyncIterator[CloudUnderTest]:
    async with CloudProcess(arguments=("--linger", str(LINGER), *arguments)) as cloud:
        yield await logged_in(cloud)


def _with_metrics() -> tuple[str, tuple[str, ...]]:
    """Return the address of metrics, and the options of a cloud that serves them there, and logs all as JSON."""
    [port] = free_ports(1)
    options = ("--metrics", str(port), "--metrics-robots", "--log-format", "json", "--log-level", "info")
    return f"http://127.0.0.1:{port}/metrics", options


def _scrape(address: str) -> bytes:
    with urllib.request.urlopen(address) as answer:
        return bytes(answer.read())


async def _scrapes(progress: Progress, quick: bool) -> list[Figure]:
    address, options = _with_metrics()
    robots, count = (QUICK_ROBOTS, QUICK_SCRAPES) if quick else (ROBOTS, SCRAPES)
    async with _cloud(*options) as target, contextlib.AsyncExitStack() as stack:
        await target.publish(fleet.MAP, warehouse(3, *fleet.SIDES))
        task = progress.add_task("robots that stand", total=robots)
        for number in range(robots):
            url = await target.register(f"stands-{number}", fleet.MAP, (2.0, 2.0, 0.0))
            await stack.enter_async_context(websockets.connect(url, max_size=None))
            progress.advance(task)
        text = b""
        while text.count(b"ppaas_robot_connected{") < robots:
            await asyncio.sleep(1.0)
            text = await asyncio.to_thread(_scrape, address)
        return await _time_of(target, address, count, f"{robots} robots by name, {len(text) >> 10} KiB")


async def _time_of(target: CloudUnderTest, address: str, count: int, note: str) -> list[Figure]:
    idle = await _used(target, asyncio.sleep(IDLE)) / IDLE
    times: list[float] = []
    began = monotonic()
    used = await _used(target, _scrape_often(address, count, times)) - idle * (monotonic() - began)
    each = max(0.0, used) / count
    return [
        median_of(PART, "scrape", times, "ms", limit=SCRAPE_LIMIT, note=note),
        Figure(
            PART, f"scrapes each {INTERVAL:g} s", round(100.0 * each / INTERVAL, 4), "% of a core", limit=SHARE_LIMIT,
            note=f"{1e3 * each:.1f} ms of CPU of master and endpoints for each",
        ),
    ]  # fmt: skip


async def _used(target: CloudUnderTest, work: Awaitable[None]) -> float:
    """Return the CPU time that master and endpoints use meanwhile [s]."""
    assert target.pid is not None
    before = cpu_seconds(target.pid, set())["web"]
    await work
    return cpu_seconds(target.pid, set())["web"] - before


async def _scrape_often(address: str, count: int, times: list[float]) -> None:
    for _ in range(count):
        began = monotonic()
        await asyncio.to_thread(_scrape, address)
        times.append(monotonic() - began)


# -- costs -------------------------------------------------------------------------------------------------------------


async def _costs(progress: Progress, quick: bool) -> list[Figure]:
    """Compare the CPU time of clouds whose robots drive, in turns with and without metrics and logs."""
    plan = fleet.QUICK if quick else fleet.Plan(warm=6.0, seconds=2 * INTERVAL)
    robots, turns = (QUICK_ROBOTS, 1) if quick else (DRIVING, TURNS)
    used: dict[bool, list[float]] = {False: [], True: []}
    for turn in range(2 * turns):
        watched = is_watched(turn)
        used[watched].append(await _cores(progress, plan, robots, watched=watched))
    return [cost_of(used[False], used[True], robots)]


def is_watched(turn: int) -> bool:
    """Return whether a turn is with metrics and logs: the order (no, yes, yes, no) has a drift on both sides."""
    return turn % 4 in (1, 2)


def cost_of(plain: list[float], watched: list[float], robots: int) -> Figure:
    """Return by how much more CPU time is used with metrics and logs than without, pair by pair of turns [cores]."""
    growth = [100.0 * (more / less - 1.0) for less, more in zip(plain, watched, strict=True)]
    note = f"{robots} robots drive; without: {statistics.median(plain):.3f} cores; median of {len(plain)} pairs"
    return median_of(PART, "metrics and JSON logs", growth, "% more CPU", limit=COST_LIMIT, note=note)


async def _cores(progress: Progress, plan: fleet.Plan, robots: int, *, watched: bool) -> float:
    """Return the CPU time that a cloud uses for driving robots [cores]."""
    address, options = _with_metrics() if watched else ("", ())
    async with _cloud(*options) as target:
        grid = warehouse(3, *fleet.SIDES)
        await target.publish(fleet.MAP, grid)
        scraping = asyncio.create_task(_scrape_regularly(address)) if watched else None
        try:
            trial = await fleet.SimulatedFleet(target, grid, robots).trial(plan, progress)
        finally:
            if scraping is not None:
                scraping.cancel()
    return sum(share for kind, share in trial.shares.items() if kind != "simulator")


async def _scrape_regularly(address: str) -> None:
    while True:
        await asyncio.sleep(INTERVAL)
        await asyncio.to_thread(_scrape, address)
