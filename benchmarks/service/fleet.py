"""Largest fleet of simulated robots that one machine serves in time, the simulator included."""

import asyncio
import contextlib
import os
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

import numpy as np
from rich.progress import Progress

from benchmarks.harness.cloud_under_test import CloudUnderTest
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.process_usage import ProcessMemory, cpu_seconds, memory_of
from benchmarks.harness.roaming_robot import RoamingRobot, roaming_robot
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.maps.generate import warehouse
from ppaas.maps.grid import GridMap
from robots.sim.courses import Course, CoursePlanner
from robots.sim.simulator import Simulator
from robots.sim.world import World

PART = "fleet"
MAP = "bench-fleet"
SIDES = 45.0, 30.0
"""Sides of the warehouse [m]."""

GAP_LIMIT = 0.1
"""Largest acceptable 99th percentile of the time between two commands [s]."""

LEAST_ROBOTS = 10
MOST_ROBOTS = 64
MEMORY_LIMIT_MB = 25.0


@dataclass(frozen=True, slots=True)
class Plan:
    """Sizes of fleets and durations of their trials.

    Parameters
    ----------
    first : int
        Number of robots of the first trial.
    most : int
        Largest number of robots.
    warm, seconds : float
        Durations of the warm-up and of the measurement [s].
    driven : float
        Total driving time before memory is measured [s].
    weighed : tuple of int
        Sizes of fleets whose memory is measured; the fewer containers, the larger the share of each in shared
        memory.
    """

    first: int = 8
    most: int = MOST_ROBOTS
    warm: float = 6.0
    seconds: float = 15.0
    driven: float = 60.0
    weighed: tuple[int, ...] = (3, LEAST_ROBOTS)


QUICK = Plan(first=2, most=2, warm=2.0, seconds=4.0, driven=6.0, weighed=(2,))


@dataclass(frozen=True, slots=True)
class Trial:
    """Result of a fleet of one size.

    Parameters
    ----------
    robots : int
        Number of robots.
    gaps : array
        All gaps between commands, sorted [s].
    shares : dict
        CPUs used by each kind of process.
    late : float
        Delay of the simulated world at the end [s]; the trial is invalid if the world was too slow.
    memory : list of ProcessMemory
        Memory of the containers at the end.
    """

    robots: int
    gaps: np.ndarray
    shares: dict[str, float]
    late: float
    memory: list[ProcessMemory]

    def gap(self, percentile: float) -> float:
        """Return a percentile of the gaps [ms]; infinite without commands."""
        return 1e3 * float(np.percentile(self.gaps, percentile)) if len(self.gaps) else float("inf")

    @property
    def good(self) -> bool:
        """Whether commands arrived in time, and the simulated world kept up."""
        return self.gap(99) <= 1e3 * GAP_LIMIT and self.late < GAP_LIMIT

    def cpus(self) -> str:
        """Return the CPUs used by each kind of process, as text."""
        return ", ".join(f"{kind} {share:.2f}" for kind, share in self.shares.items())

    def sentence(self) -> str:
        """Return the result as a sentence."""
        gaps = ", ".join(
            f"{name} {self.gap(percent):.0f}" for name, percent in (("p50", 50), ("p99", 99), ("most", 100))
        )
        return f"{self.robots} robots: gap {gaps} ms; CPUs: {self.cpus()}; world {1e3 * self.late:.0f} ms late"


async def measure(target: CloudUnderTest, progress: Progress, quick: bool) -> list[Figure]:
    """Search the largest fleet that is served in time; then measure the memory of containers of small fleets."""
    plan = QUICK if quick else Plan()
    grid = warehouse(3, *SIDES)
    await target.publish(MAP, grid)

    async def drive(robots: int) -> Trial:
        try:
            trial = await SimulatedFleet(target, grid, robots).trial(plan, progress)
        except Unavailable as error:  # the cloud is too busy for another robot
            progress.console.print(f"  {robots} robots: {error}")
            return Trial(robots, np.empty(0), {}, 0.0, [])
        progress.console.print(f"  {trial.sentence()}")
        return trial

    trials = await search(drive, plan.first, plan.most)
    to_weigh = Plan(warm=plan.driven - plan.seconds, seconds=plan.seconds)
    weighed = [await SimulatedFleet(target, grid, robots).trial(to_weigh, progress) for robots in plan.weighed]
    return [*_of_search(trials), *(figure for trial in weighed for figure in _of_memory(trial, plan.driven))]


async def search(drive: Callable[[int], Awaitable[Trial]], first: int, most: int) -> list[Trial]:
    """Double the fleet until it is too large, then bisect; return all trials in order of size.

    Parameters
    ----------
    drive : callable
        Runs a trial with a number of robots.
    first, most : int
        Number of robots of the first trial, and largest number.
    """
    trials: list[Trial] = []
    good, bad, robots = 0, most + 1, first
    while good < robots < bad:
        trial = await drive(robots)
        trials.append(trial)
        good, bad = (robots, bad) if trial.good else (good, robots)
        robots = min(2 * good, most) if bad > most else (good + bad) // 2
    return sorted(trials, key=lambda trial: trial.robots)


class SimulatedFleet:
    """Simulated robots in one world, each with its container.

    Parameters
    ----------
    target : CloudUnderTest
        The cloud.
    grid : GridMap
        Map of the world.
    robots : int
        Number of robots.
    """

    def __init__(self, target: CloudUnderTest, grid: GridMap, robots: int) -> None:
        self._target = target
        self._robots = robots
        self._courses = CoursePlanner(grid, robots).choose(robots, 2)
        self._world = World(grid, robots)

    async def trial(self, plan: Plan, progress: Progress) -> Trial:
        """Run the robots, and return the result."""
        async with contextlib.AsyncExitStack() as stack:
            simulator = Simulator(self._world)
            running = asyncio.create_task(simulator.run())
            stack.callback(running.cancel)
            roamers = [await self._send_out(stack, n, c) for n, c in enumerate(self._courses)]
            await self._pass(plan.warm, "warming up", progress)
            return await self._look(plan, roamers, simulator, progress)

    async def drive_off(self) -> None:
        """Run the robots until each of them has received a command for its goal."""
        async with contextlib.AsyncExitStack() as stack:
            running = asyncio.create_task(Simulator(self._world).run())
            stack.callback(running.cancel)
            for roamer in [await self._send_out(stack, n, c) for n, c in enumerate(self._courses)]:
                await roamer.drives.wait()

    async def _send_out(self, stack: contextlib.AsyncExitStack, number: int, course: Course) -> RoamingRobot:
        name = f"bench-{self._robots}-{number}"
        await self._target.register(name, MAP, course.start)
        robot = self._world.add_robot(course.start)
        url, token = self._target.url, self._target.token
        return await stack.enter_async_context(roaming_robot(url, token, name, robot, course))

    async def _look(self, plan: Plan, roamers: list[RoamingRobot], simulator: Simulator, progress: Progress) -> Trial:
        containers = await self._pids()
        for roamer in roamers:
            roamer.gaps.clear()
        before, began = self._cpu(containers), monotonic()
        await self._pass(plan.seconds, "measuring", progress)
        took, late = monotonic() - began, simulator.due() * self._world.dt
        shares = {kind: (seconds - before[kind]) / took for kind, seconds in self._cpu(containers).items()}
        gaps = np.sort(np.concatenate([np.array(roamer.gaps, dtype=np.float64) for roamer in roamers]))
        memory = [memory_of(pid) for pid in sorted(containers)] if self._target.pid is not None else []
        return Trial(self._robots, gaps, shares, late, memory)

    async def _pids(self) -> set[int]:
        listed = await self._target.rest.items("/v1/containers")
        return {c["pid"] for c in listed if (c["robot"] or "").startswith(f"bench-{self._robots}-")}

    def _cpu(self, containers: set[int]) -> dict[str, float]:
        if self._target.pid is None:
            return {"simulator": sum(os.times()[:2])}
        return cpu_seconds(self._target.pid, containers)

    async def _pass(self, seconds: float, what: str, progress: Progress) -> None:
        task = progress.add_task(f"{self._robots} robots, {what}", total=seconds)
        began = monotonic()
        while (passed := monotonic() - began) < seconds:
            progress.update(task, completed=passed)
            await asyncio.sleep(min(1.0, seconds - passed))
        progress.remove_task(task)


def _of_search(trials: list[Trial]) -> list[Figure]:
    good = [trial for trial in trials if trial.good]
    most = good[-1].robots if good else 0
    largest = Figure(
        PART, "robots in time", most, "robots", limit=LEAST_ROBOTS, floor=True,
        note=f"cmd_vel gap p99 ≤ {1e3 * GAP_LIMIT:g} ms, simulator included",
    )  # fmt: skip
    rows = [Figure(PART, f"gap p99 of {t.robots}", round(t.gap(99), 1), "ms", round(t.gap(50), 1), round(t.gap(100), 1),
                   1e3 * GAP_LIMIT, note=f"CPUs: {t.cpus()}") for t in trials]  # fmt: skip
    return [largest, *rows]


def _of_memory(trial: Trial, seconds: float) -> list[Figure]:
    if not trial.memory:
        return []
    name = f"memory of each of {trial.robots}"
    note = f"PSS beyond the shared map, after {seconds:g} s of driving"
    return [
        median_of("containers", name, [m.pss for m in trial.memory], "MB", limit=MEMORY_LIMIT_MB, note=note),
        median_of("containers", "of it private", [m.private for m in trial.memory], "MB"),
        median_of("containers", "map beside it", [m.shared_map for m in trial.memory], "MB"),
    ]
