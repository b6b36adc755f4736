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

ORPHANED = 45.0
"""Time for the machine of a replaced master to end [s]: ``--adopt-within``, and the end of its containers."""

TEXTS = 20
"""Number of reasons of goals that were not reached in the report."""

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
    robots, operators, machines : int
        Number of robots, of those to which an operator sends the goals, and of machines including the cloud's local
        machine.
    standby : bool
        Whether a second cloud process stands by.
    every : float
        Mean time between two faults [s].
    seed : int
        Seed of the faults, the maps and the courses.
    sides : tuple of float
        Width and height of the offices in which robots drive [m].
    """

    seconds: float = 600.0
    robots: int = 10
    operators: int = 3
    machines: int = 3
    standby: bool = True
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
    site = ChaosSite(options.machines, standby=options.standby)
    wrong: list[str] = []
    began = monotonic()

    def tell(what: str) -> None:
        wrong.append(f"{monotonic() - began:.1f} s: {what}")

    leftovers = Leftovers(site.folder, tell)
    stage = [_scene(options, number) for number in range(min(MAPS, options.robots))]
    async with site:
        target = await site.login()
        robots = [robot for scene in stage for robot in await scene.enter(target, tell)]
        requester = PathRequester(target.rest, stage[0].map_id, stage[0].courses)
        random = Random(options.seed)
        injector = Injector(target.rest, site.folder, random, options.machines, tell, standby=options.standby)
        async with asyncio.TaskGroup() as group:
            works = (*(scene.simulator.run() for scene in stage), requester.run(), _look_on(leftovers))
            meanwhile = [group.create_task(work) for work in works]
            await _drive(options, robots, injector, leftovers, progress)
            for task in meanwhile:
                task.cancel()
        await _end(site, leftovers, tell)
        own = {robot.name: robot.silences.gaps for robot in robots}
        told = {"paths": dict(requester.answers), "cloud_starts": site.restarts, "wrong": wrong}
        told["take_overs"] = site.take_overs
        told |= {"log": log_of(injector.faults, began), "silences": longest_silences(injector.faults, own, began)}
        return _reckon(options, robots, injector, **told)


@dataclass(frozen=True, slots=True)
class _Scene:
    map_id: str
    grid: GridMap
    world: World
    courses: Sequence[Course]
    operated: int
    simulator: Simulator

    async def enter(self, target: Target, tell: Callable[[str], None]) -> list[RobotUnderTest]:
        await target.publish(self.map_id, self.grid)
        robots = []
        for number, course in enumerate(self.courses):
            name = f"{self.map_id}-{number}"
            await target.register(name, self.map_id, course.start, CORES)
            simulated = self.world.add_robot(course.start)
            address = target.url, target.token
            robots.append(
                RobotUnderTest(
                    address, name, simulated, course, tell, clock=self.world.time, operator=number < self.operated
                )
            )
        return robots


def _scene(options: ChaosOptions, number: int) -> _Scene:
    grid = office(options.seed + number, *options.sides)
    robots, operated = (len(range(number, count, MAPS)) for count in (options.robots, options.operators))
    courses = CoursePlanner(grid, options.seed + number).choose(robots, 2)
    world = World(grid, options.seed + number)
    return _Scene(f"chaos-{number}", grid, world, courses, operated, Simulator(world))


async def _look_on(leftovers: Leftovers) -> None:
    while True:
        await asyncio.to_thread(leftovers.look)
        await asyncio.sleep(LOOK)


async def _drive(
    options: ChaosOptions, robots: list[RobotUnderTest], injector: Injector, leftovers: Leftovers, progress: Progress
) -> None:
    """Run the robots, inject faults once all of them drive, and wait until each has ended its goal."""
    async with asyncio.TaskGroup() as group:
        for robot in robots:
            group.create_task(robot.run())
        await asyncio.gather(*(robot.checks.driven.wait() for robot in robots))
        await asyncio.to_thread(leftovers.count_files)
        faults = group.create_task(injector.run(options.seconds, options.every))
        await _show(faults, options.seconds, injector, progress)
        for robot in robots:
            robot.enough()
    await asyncio.to_thread(leftovers.count_files, MORE_FILES + FILES_A_ROBOT * options.robots)


async def _end(site: ChaosSite, leftovers: Leftovers, tell: Callable[[str], None]) -> None:
    try:
        await site.stop()
    except Unavailable as error:
        tell(str(error))
    end = monotonic() + (ORPHANED if site.has_standby else 0.0)
    while monotonic() < end:
        running = await asyncio.to_thread(leftovers.look)
        if not running:
            break
        await asyncio.sleep(LOOK)
    leftovers.at_end()


async def _show(faults: "asyncio.Task[None]", seconds: float, injector: Injector, progress: Progress) -> None:
    task, began = progress.add_task("faults", total=seconds), monotonic()
    while not faults.done():
        last = injector.faults[-1].name if injector.faults else ""
        progress.update(task, completed=monotonic() - began, description=f"{len(injector.faults)} faults: {last}")
        await asyncio.wait({faults}, timeout=LOOK)
    progress.remove_task(task)
    faults.result()


def _reckon(options: ChaosOptions, robots: list[RobotUnderTest], injector: Injector, **rest: Any) -> ChaosReport:
    goals = [robot.sender.goals for robot in robots]
    endings = sum((Counter(one.endings) for one in goals), Counter())
    gaps = [gap for robot in robots for gap in robot.checks.uncommanded.gaps]
    silences = [gap for robot in robots for gap in robot.silences.gaps]
    return ChaosReport(
        seed=options.seed,
        robots=options.robots,
        operators=options.operators,
        machines=options.machines,
        standby=options.standby,
        seconds=options.seconds,
        faults=dict(Counter(fault.name for fault in injector.faults)),
        longest_gap_s=longest_by_fault(injector.faults, gaps),
        longest_silence_s=longest_by_fault(injector.faults, silences),
        goals={"sent": sum(one.sent for one in goals)} | {e: endings[e] for e in ("result", "status", "lost")},
        statuses=dict(sum((one.statuses for one in goals), Counter())),
        not_reached=dict(sum((one.texts for one in goals), Counter()).most_common(TEXTS)),
        commands=sum(robot.checks.commands for robot in robots),
        sessions=sum(robot.sessions for robot in robots),
        **rest,
    )
