"""Chaos run: a cloud with several machines, driving robots, injected faults, and the report."""

import asyncio
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

from rich.progress import Progress

from benchmarks.chaos.injector import Injector
from benchmarks.chaos.leftovers import Leftovers
from benchmarks.chaos.path_requester import PathRequester
from benchmarks.chaos.report import ChaosReport, log_of, longest_by_fault, longest_silences
from benchmarks.chaos.robot_under_test import RobotUnderTest
from benchmarks.chaos.site import ChaosSite
from benchmarks.harness.cloud_under_test import Target
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.maps.generate import office
from ppaas.maps.grid import GridMap
from robots.sim.courses import Course, CoursePlanner
from robots.sim.simulator import Simulator
from robots.sim.world import World

CORES = 0.1
"""Size of a container [cores]: small enough that one machine can run all robots while the others are lost."""

MAPS = 2
"""Number of maps: the balancer keeps robots of a map together, so several maps use several machines."""

LOOK = 1.0
"""Period at which leftovers are checked [s]."""
MORE_FILES = 16
FILES_A_ROBOT = 8
"""Allowed increase of open files of a process, and for each robot: all robots may be on one machine at the end."""


@dataclass(frozen=True, slots=True)
class ChaosOptions:
    """Settings of a chaos run.

    Parameters
    ----------
    seconds : float
        Duration of the injection [s].
    robots, machines : int
        Number of robots, and of machines including the cloud's local machine.
    every : float
        Mean time between two faults [s].
    seed : int
        Seed of the faults, the maps and the courses.
    sides : tuple of float
        Width and height of the offices in which robots drive [m].
    """

    seconds: float = 600.0
    robots: int = 10
    machines: int = 3
    every: float = 5.0
    seed: int = 1
    sides: tuple[float, float] = (16.0, 14.0)


async def run(options: ChaosOptions, progress: Progress) -> ChaosReport:
    """Start a cloud, inject faults, and return the report.

    Raises
    ------
    PPaaSError
        The cloud did not start.
    """
    site = ChaosSite(options.machines)
    wrong: list[str] = []
    began = monotonic()

    def tell(what: str) -> None:
        wrong.append(f"{monotonic() - began:.1f} s: {what}")

    traces = Leftovers(site.folder, tell)
    stage = [_scene(options, number) for number in range(min(MAPS, options.robots))]
    async with site:
        target = await site.login()
        wanderers = [wanderer for scene in stage for wanderer in await scene.enter(target, tell)]
        asker = PathRequester(target.rest, stage[0].map_id, stage[0].courses)
        injector = Injector(target.rest, site.folder, Random(options.seed), options.machines, tell)
        async with asyncio.TaskGroup() as group:
            works = (*(scene.simulator.run() for scene in stage), asker.run(), _look_on(traces))
            meanwhile = [group.create_task(work) for work in works]
            await _drive(options, wanderers, injector, traces, progress)
            for task in meanwhile:
                task.cancel()
        await _end(site, traces, tell)
        own = {wanderer.name: wanderer.silences.gaps for wanderer in wanderers}
        told = {"paths": dict(asker.answers), "cloud_starts": site.restarts, "wrong": wrong}
        told |= {"log": log_of(injector.faults, began), "silences": longest_silences(injector.faults, own, began)}
        return _reckon(options, wanderers, injector, **told)


@dataclass(frozen=True, slots=True)
class _Scene:
    map_id: str
    grid: GridMap
    world: World
    courses: Sequence[Course]
    simulator: Simulator

    async def enter(self, target: Target, tell: Callable[[str], None]) -> list[RobotUnderTest]:
        await target.publish(self.map_id, self.grid)
        wanderers = []
        for number, course in enumerate(self.courses):
            name = f"{self.map_id}-{number}"
            await target.register(name, self.map_id, course.start, CORES)
            robot = self.world.add_robot(course.start)
            wanderers.append(RobotUnderTest((target.url, target.token), name, robot, course, tell))
        return wanderers


def _scene(options: ChaosOptions, number: int) -> _Scene:
    grid = office(options.seed + number, *options.sides)
    robots = len(range(number, options.robots, MAPS))
    courses = CoursePlanner(grid, options.seed + number).choose(robots, 2)
    world = World(grid, options.seed + number)
    return _Scene(f"chaos-{number}", grid, world, courses, Simulator(world))


async def _look_on(traces: Leftovers) -> None:
    while True:
        await asyncio.to_thread(traces.look)
        await asyncio.sleep(LOOK)


async def _drive(
    options: ChaosOptions, wanderers: list[RobotUnderTest], injector: Injector, traces: Leftovers, progress: Progress
) -> None:
    """Run the robots, inject faults once all of them drive, and wait until each has ended its goal."""
    async with asyncio.TaskGroup() as group:
        for wanderer in wanderers:
            group.create_task(wanderer.run())
        await asyncio.gather(*(wanderer.witness.driven.wait() for wanderer in wanderers))
        await asyncio.to_thread(traces.count_files)
        faults = group.create_task(injector.run(options.seconds, options.every))
        await _show(faults, options.seconds, injector, progress)
        for wanderer in wanderers:
            wanderer.enough()
    await asyncio.to_thread(traces.count_files, MORE_FILES + FILES_A_ROBOT * options.robots)


async def _end(site: ChaosSite, traces: Leftovers, tell: Callable[[str], None]) -> None:
    try:
        await site.stop()
    except Unavailable as error:
        tell(str(error))
    traces.at_end()


async def _show(faults: "asyncio.Task[None]", seconds: float, injector: Injector, progress: Progress) -> None:
    task, began = progress.add_task("faults", total=seconds), monotonic()
    while not faults.done():
        last = injector.faults[-1].name if injector.faults else ""
        progress.update(task, completed=monotonic() - began, description=f"{len(injector.faults)} faults: {last}")
        await asyncio.wait({faults}, timeout=LOOK)
    progress.remove_task(task)
    faults.result()


def _reckon(options: ChaosOptions, wanderers: list[RobotUnderTest], injector: Injector, **rest: Any) -> ChaosReport:
    endings = sum((Counter(wanderer.goals.endings) for wanderer in wanderers), Counter())
    gaps = [gap for wanderer in wanderers for gap in wanderer.witness.uncommanded.gaps]
    silences = [gap for wanderer in wanderers for gap in wanderer.silences.gaps]
    return ChaosReport(
        seed=options.seed,
        robots=options.robots,
        machines=options.machines,
        seconds=options.seconds,
        faults=dict(Counter(fault.name for fault in injector.faults)),
        longest_gap_s=longest_by_fault(injector.faults, gaps),
        longest_silence_s=longest_by_fault(injector.faults, silences),
        goals={"sent": sum(w.goals.sent for w in wanderers)} | {e: endings[e] for e in ("result", "status", "lost")},
        statuses=dict(sum((w.goals.statuses for w in wanderers), Counter())),
        commands=sum(wanderer.witness.commands for wanderer in wanderers),
        sessions=sum(wanderer.sessions for wanderer in wanderers),
        **rest,
    )
