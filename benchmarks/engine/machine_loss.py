"""Recovery from the loss of a machine: time until its robots are served by another one."""

import contextlib
from collections.abc import Callable

from rich.progress import Progress

from benchmarks.engine import baselines
from benchmarks.engine.container_crash import served_by_another
from benchmarks.engine.driving_robot import MAP, driven, grid_to_drive_on
from benchmarks.engine.options import EngineOptions
from benchmarks.engine.samples import median_and_worst, served_after
from benchmarks.engine.site import EngineSite, SecondMachine
from benchmarks.harness.figures import Figure
from ppaas.clock import monotonic
from ppaas.errors import Unavailable

PART = "lost"
LOSSES, QUICK = 3, 1
LIMIT_MS = 5000.0

FAULTS: dict[str, tuple[str, Callable[[SecondMachine], None]]] = {
    "machine killed": ("kill -9 of its agent, on Ray of all of its node", lambda machine: machine.kill()),
    "machine frozen": ("its agent stands still, and says nothing", lambda machine: machine.freeze()),
}
"""Faults of a machine by name: description and action."""


async def measure(site: EngineSite, options: EngineOptions, progress: Progress) -> list[Figure]:
    """Lose machines that serve a driving robot, a new one each time; the cloud's local machine stays."""
    await site.target.publish(MAP, grid_to_drive_on())
    figures: list[Figure] = []
    for name, (how, fault) in tuple(FAULTS.items())[: options.of(len(FAULTS), 1)]:
        losses = progress.track(range(options.of(LOSSES, QUICK)), description=name)
        silences = [await _lose(site, f"bench-lost-{len(figures)}-{number}", fault) for number in losses]
        note = f"{options.runtime}; {how}, until its robot is commanded from another machine"
        figures += median_and_worst(PART, name, silences, limit=LIMIT_MS, note=note)
    return [*figures, baselines.python_figure(PART, [await baselines.python() for _ in range(LOSSES)])]


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
