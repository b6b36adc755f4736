"""Recovery: time until robots are served again whose container was killed, or whose machine was lost."""

import asyncio
import contextlib
import os
import signal
from collections.abc import Callable
from typing import Any

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.driving_robot import MAP, PATIENCE, CommandObserver, driven, grid_to_drive_on
from benchmarks.engine.options import PAUSES, EngineOptions
from benchmarks.engine.site import EngineSite, SecondMachine
from benchmarks.harness.figures import Figure, median_and_worst, served_after
from ppaas.clock import monotonic
from ppaas.errors import Unavailable

CRASH = "crash"
CRASHES, QUICK_CRASHES = 10, 1
CRASH_LIMITS_MS = {"process": 500.0, "ray": 500.0}
"""Largest acceptable time by runtime; none for runtimes whose reserve of containers may be empty."""


async def measure_crashes(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Kill one container of each of several robots; repeated crashes of one robot would be replaced with a delay."""
    grid = grid_to_drive_on()
    await site.target.publish(MAP, grid)
    silences, started = [], []
    for number in progress.track(range(options.of(CRASHES, QUICK_CRASHES)), description="killing containers"):
        robot = f"bench-crash-{number}"
        async with driven(site, robot, grid) as observer:
            await asyncio.sleep(PAUSES.get(options.runtime, 0.0))
            silences.append(await _crash(site, robot, observer))
        started.append(await baselines.python())
    note = f"{options.runtime}; it drives; from kill -9 of its container until it is commanded again"
    return [
        *median_and_worst(CRASH, "robot served again", silences, limit=CRASH_LIMITS_MS.get(options.runtime), note=note),
        baselines.python_figure(CRASH, started),
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


# -- recovery from the loss of a machine -------------------------------------------------------------------------------

LOSS = "lost"
LOSSES, QUICK_LOSSES = 3, 1
LOSS_LIMIT_MS = 5000.0

MACHINE_FAULTS: dict[str, tuple[str, Callable[[SecondMachine], None]]] = {
    "machine killed": ("kill -9 of its agent, on Ray of all of its node", lambda machine: machine.kill()),
    "machine frozen": ("its agent stands still, and says nothing", lambda machine: machine.freeze()),
}
"""Faults of a machine by name: description and action."""


async def measure_losses(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Lose machines that serve a driving robot, a new one each time; the cloud's local machine stays."""
    await site.target.publish(MAP, grid_to_drive_on())
    figures: list[Figure] = []
    for name, (how, fault) in tuple(MACHINE_FAULTS.items())[: options.of(len(MACHINE_FAULTS), 1)]:
        losses = progress.track(range(options.of(LOSSES, QUICK_LOSSES)), description=name)
        silences = [await _lose(site, f"bench-lost-{len(figures)}-{number}", fault) for number in losses]
        note = f"{options.runtime}; {how}, until its robot is commanded from another machine"
        figures += median_and_worst(LOSS, name, silences, limit=LOSS_LIMIT_MS, note=note)
    return [*figures, baselines.python_figure(LOSS, [await baselines.python() for _ in range(LOSSES)])]


async def _lose(site: EngineSite, robot: str, fault: Callable[[SecondMachine], None]) -> float:
    async with site.second_machine() as machine, contextlib.AsyncExitStack() as stack:
        async with site.only_on(machine.name):
            observer = await stack.enter_async_context(driven(site, robot, grid_to_drive_on()))
        before = await site.container(robot)
        if before["machine"] != machine.name:
            raise Unavailable(f"robot {robot!r} is on machine {before['machine']!r}, not on {machine.name!r}")
        lost = monotonic()
        fault(machine)
        await served_by_another(site, robot, before)
        await observer.hears(1)
        return served_after(observer.commands, lost)
