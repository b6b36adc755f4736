"""Chaos run: a cloud with several machines, driving robots, injected faults, a watch of traffic, and the report."""

import asyncio
import logging
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

from rich.progress import Progress

from benchmarks.chaos.clients import PathRequester, clients_of
from benchmarks.chaos.cloud_processes import Leftovers
from benchmarks.chaos.faults import CloudSize, Injector
from benchmarks.chaos.report import ChaosReport, log_of, longest_by_fault, longest_silences, strays_of
from benchmarks.chaos.robot_under_test import RobotUnderTest, end_together
from benchmarks.chaos.scene import ChaosScene, in_office, in_traffic
from benchmarks.chaos.site import ChaosSite
from ppaas.clock import monotonic
from ppaas.errors import PPaaSError, Unavailable
from robots.client.cloud_url import path_of
from robots.client.rest import RestClient

logger = logging.getLogger(__name__)

# -- watch of the traffic of a map -------------------------------------------------------------------------------------

PERIOD = 2.0
"""Period at which the cloud is asked [s]."""


class TrafficWatch:
    """Asks the cloud for the traffic of a map, and adds its last answer to errors.

    Parameters
    ----------
    rest : RestClient
        Login of the owner of the robots.
    map_id : str
        Id of the map.
    tell : callable
        Called with a description of each error.
    """

    def __init__(self, rest: RestClient, map_id: str, tell: Callable[[str], None]) -> None:
        self._rest = rest
        self._path = path_of("maps", map_id, "traffic")
        self._tell = tell
        self._seen = "not known"
        self._seen_at = monotonic()

    def tell(self, what: str) -> None:
        """Tell an error, with the traffic as it was last seen."""
        self._tell(f"{what}; traffic {monotonic() - self._seen_at:.0f} s before: {self._seen}")

    async def run(self) -> None:
        """Ask until cancelled; while the cloud does not answer, the last answer is kept."""
        while True:
            try:
                self._see(await self._rest.get(self._path))
            except PPaaSError as error:
                logger.info("no answer about the traffic: %s", error)
            await asyncio.sleep(PERIOD)

    def _see(self, traffic: Any) -> None:
        self._seen = ", ".join(map(_in_words, traffic["robots"]))
        self._seen_at = monotonic()


def _in_words(robot: dict[str, Any]) -> str:
    x, y, _ = robot["pose"]
    waits = f" for {robot['waits_for']} since {robot['waited']:.0f} s" if robot["waits_for"] else ""
    return f"{robot['robot']} {robot['state']}{waits} at {x:.2f}, {y:.2f}"


MAPS = 2
"""Number of maps: the balancer keeps robots of a map together, so several maps use several machines."""

ORPHANED = 45.0
"""Time for the machine of a replaced master to end [s]: ``--adopt-within``, and the end of its containers."""

TEXTS = 20
"""Number of reasons of goals that were not reached in the report."""

WATCH = 0.1
"""Period at which contacts of robots in traffic are looked for [s]."""

LOOK = 1.0
"""Period at which leftovers are checked [s]."""
MORE_FILES = 16
FILES_A_CONTAINER = 8
"""Allowed increase of open files of a process, and for each container: all of them may be on one machine at the end."""


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
    fleet : int
        Number of further robots, which take part in the traffic of a warehouse.
    hall : tuple of float
        Width and height of it [m].
    throttled : int
        Number of further clients of each robot, which subscribe with throttle rates.
    """

    seconds: float = 600.0
    robots: int = 10
    operators: int = 3
    machines: int = 3
    standby: bool = True
    every: float = 5.0
    seed: int = 1
    sides: tuple[float, float] = (16.0, 14.0)
    fleet: int = 0
    hall: tuple[float, float] = (18.0, 12.0)
    throttled: int = 0


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
    offices = [_scene(options, number) for number in range(min(MAPS, options.robots))]
    fleets = [in_traffic(options.seed, options.fleet, options.hall)] if options.fleet else []
    stage = [*offices, *fleets]
    async with site:
        target = await site.login()
        watches = [TrafficWatch(target.rest, scene.map_id, tell) for scene in fleets]
        tells = [*(tell for _ in offices), *(watch.tell for watch in watches)]
        crews = [await scene.enter(target, own) for scene, own in zip(stage, tells, strict=True)]
        robots = [robot for crew in crews for robot in crew]
        listeners = clients_of((target.url, target.token), [robot.name for robot in robots], options.throttled, tell)
        requester = PathRequester(target.rest, stage[0].map_id, stage[0].courses)
        random = Random(options.seed)
        cloud = CloudSize(options.machines, standby=options.standby, traffic=bool(fleets))
        injector = Injector(target.rest, site.folder, random, cloud, tell)
        async with asyncio.TaskGroup() as group:
            works = (*(scene.simulator.run() for scene in stage), requester.run(), _look_on(leftovers))
            works += (*(watch.run() for watch in watches), listeners.run())
            works += tuple(_count_contacts(*each) for each in zip(stage, crews, tells, strict=True) if each[0].traffic)
            meanwhile = [group.create_task(work) for work in works]
            await _drive(options, robots, injector, leftovers, progress)
            for task in meanwhile:
                task.cancel()
        listeners.check()
        await _end(site, leftovers, tell)
        own = {robot.name: robot.silences.gaps for robot in robots}
        told = {"paths": dict(requester.answers), "cloud_starts": site.restarts, "wrong": wrong}
        told |= {"take_overs": site.take_overs, "fleet_contacts": sum(scene.contacts for scene in fleets)}
        told |= {"throttled": options.throttled, "throttled_messages": listeners.messages}
        told |= {"log": log_of(injector.faults, began), "silences": longest_silences(injector.faults, own, began)}
        told |= {"strays": strays_of(injector.faults, {robot.name: robot.strays.gaps for robot in robots}, began)}
        return _reckon(options, robots, injector, **told)


def _scene(options: ChaosOptions, number: int) -> ChaosScene:
    robots, operated = (len(range(number, count, MAPS)) for count in (options.robots, options.operators))
    return in_office(number, options.seed + number, robots, operated, options.sides)


async def _count_contacts(scene: ChaosScene, robots: Sequence[RobotUnderTest], tell: Callable[[str], None]) -> None:
    known: Counter[int] = Counter()
    while True:
        contacts = scene.world.contacts.robot_contacts
        if new := [f"{robots[index].name} ({robots[index].standing()})" for index in contacts - known]:
            known = contacts.copy()
            tell(f"robots in traffic touched each other: {', '.join(new)}")
        await asyncio.sleep(WATCH)


async def _look_on(leftovers: Leftovers) -> None:
    while True:
        await asyncio.to_thread(leftovers.look)
        await asyncio.sleep(LOOK)


async def _drive(
    options: ChaosOptions, robots: list[RobotUnderTest], injector: Injector, leftovers: Leftovers, progress: Progress
) -> None:
    """Run the robots, inject faults once all of them drive, and wait until all have ended their goals."""
    async with asyncio.TaskGroup() as group:
        for robot in robots:
            group.create_task(robot.run())
        await asyncio.gather(*(robot.checks.driven.wait() for robot in robots))
        await asyncio.to_thread(leftovers.count_files)
        faults = group.create_task(injector.run(options.seconds, options.every))
        await _show(faults, options.seconds, injector, progress)
        await end_together(robots)
    containers = len(robots) + 1 + (options.fleet > 0)  # paths are planned in another one, as is the traffic
    await asyncio.to_thread(leftovers.count_files, MORE_FILES + FILES_A_CONTAINER * containers)


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
        fleet=options.fleet,
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
