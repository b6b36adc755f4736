"""Recovery from a crash: time until a driving robot whose container was killed is served again."""

import asyncio
import os
import signal
from typing import Any

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.driving_robot import MAP, PATIENCE, CommandObserver, driven, grid_to_drive_on
from benchmarks.engine.options import PAUSES, EngineOptions
from benchmarks.engine.samples import median_and_worst, served_after
from benchmarks.engine.site import EngineSite
from benchmarks.harness.figures import Figure
from ppaas.clock import monotonic
from ppaas.errors import Unavailable

PART = "crash"
CRASHES, QUICK = 10, 1
LIMITS_MS = {"process": 500.0, "ray": 500.0}
"""Largest acceptable time by runtime; none for runtimes whose reserve of containers may be empty."""


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Kill one container of each of several robots; repeated crashes of one robot would be replaced with a delay."""
    grid = grid_to_drive_on()
    await site.target.publish(MAP, grid)
    silences, started = [], []
    for number in progress.track(range(options.of(CRASHES, QUICK)), description="killing containers"):
        robot = f"bench-crash-{number}"
        async with driven(site, robot, grid) as observer:
            await asyncio.sleep(PAUSES.get(options.runtime, 0.0))
            silences.append(await _crash(site, robot, observer))
        started.append(await baselines.python())
    note = f"{options.runtime}; it drives; from kill -9 of its container until it is commanded again"
    return [
        *median_and_worst(PART, "robot served again", silences, limit=LIMITS_MS.get(options.runtime), note=note),
        baselines.python_figure(PART, started),
    ]


async def _crash(site: EngineSite, robot: str, observer: CommandObserver) -> float:
    before = await site.container(robot)
    killed = monotonic()
    os.kill(before["pid"], signal.SIGKILL)
    await served_by_another(site, robot, before)
    await observer.hears(1)
    return served_after(observer.commands, killed)


async def served_by_another(site: EngineSite, robot: str, than: dict[str, Any]) -> dict[str, Any]:
    """Wait until a robot has another container that is ready; return it.

    Raises
    ------
    Unavailable
        The robot gets no other container within the time limit.
    """
    deadline = monotonic() + PATIENCE
    while monotonic() < deadline:
        for view in await site.containers(robot):
            if view["robot"] == robot and view["id"] != than["id"] and view["state"] == "ready":
                return view
        await asyncio.sleep(0.02)
    raise Unavailable(f"robot {robot!r} got no other container within {PATIENCE:g} s")
