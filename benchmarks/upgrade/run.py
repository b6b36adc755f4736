"""Upgrade of a cloud by the procedure of docs/upgrading.md while robots drive from goal to goal."""

import asyncio
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from random import Random

from rich.progress import Progress

from benchmarks.chaos.faults import InjectedFault
from benchmarks.chaos.message_checks import Gap
from benchmarks.chaos.report import causes_of
from benchmarks.chaos.robot_under_test import RobotUnderTest, end_together
from benchmarks.chaos.scene import ChaosScene, in_office
from benchmarks.upgrade.report import UpgradeReport, UpgradeStep
from benchmarks.upgrade.site import UpgradedSite
from ppaas.clock import monotonic
from ppaas.errors import Unavailable

SIDES = 16.0, 14.0
"""Width and height of an office [m]."""

MAPS = 2
"""Number of maps: robots of a map are kept together, so two use both machines."""

WARMUP = "before"
RELEASE_OF = "import ppaas; print(ppaas.__version__, ppaas.__path__[0])"


@dataclass(frozen=True, slots=True)
class UpgradeOptions:
    """Settings of an upgrade.

    Parameters
    ----------
    before, after : str
        Python interpreters of the releases.
    robots : int
    kill : bool
        Whether processes are killed instead of ended.
    settle : float
        Time before the upgrade, and between its steps [s].
    seed : int
        Seed of the maps, the courses and the kills.
    """

    before: str
    after: str
    robots: int = 6
    kill: bool = False
    settle: float = 10.0
    seed: int = 1


async def run(options: UpgradeOptions, progress: Progress) -> UpgradeReport:
    """Start a cloud of one release, upgrade it to another, and return the report.

    Raises
    ------
    Unavailable
        The cloud did not start, or an interpreter has no release.
    """
    releases = [await release_of(python) for python in (options.before, options.after)]
    wrong: list[str] = []
    began = monotonic()

    def tell(what: str) -> None:
        wrong.append(f"{monotonic() - began:.1f} s: {what}")

    scenes = [_scene(options, number) for number in range(min(MAPS, options.robots))]
    site = UpgradedSite(options.before, options.after, Random(options.seed) if options.kill else None)
    async with site:
        target = await site.login()
        robots = [robot for scene in scenes for robot in await scene.enter(target, tell)]
        steps: list[InjectedFault] = []
        async with asyncio.TaskGroup() as group:
            simulating = [group.create_task(scene.simulator.run()) for scene in scenes]
            driving = [group.create_task(robot.run()) for robot in robots]
            await asyncio.gather(*(robot.checks.driven.wait() for robot in robots))
            await _upgrade(site, options.settle, steps, progress)
            await end_together(robots)
            await asyncio.gather(*driving)
            for task in simulating:
                task.cancel()
        machines = {one["id"]: str(one.get("release", "")) for one in await target.rest.items("/v1/machines")}
    goals = [robot.sender.goals for robot in robots]
    return UpgradeReport(
        before=releases[0],
        after=releases[1],
        robots=options.robots,
        killed=options.kill,
        steps=[_measured(step, robots) for step in steps],
        goals=sum(one.sent for one in goals),
        lost=sum((Counter(one.endings) for one in goals), Counter())["lost"],
        commands=sum(robot.checks.commands for robot in robots),
        releases=machines,
        wrong=wrong,
    )


def _scene(options: UpgradeOptions, number: int) -> ChaosScene:
    return in_office(number, options.seed + number, len(range(number, options.robots, MAPS)), 0, SIDES)


async def _upgrade(site: UpgradedSite, settle: float, steps: list[InjectedFault], progress: Progress) -> None:
    """Do the steps of the upgrade; a time without one before them, and after each, is part of the step before."""
    rest = (await site.login()).rest
    works = {WARMUP: lambda: asyncio.sleep(settle), **site.steps(rest)}
    for name, work in progress.track(works.items(), description="upgrade"):
        step = InjectedFault(name, monotonic())
        steps.append(step)
        await work()
        step.until = monotonic()
        await asyncio.sleep(settle)


def _measured(step: InjectedFault, robots: Sequence[RobotUnderTest]) -> UpgradeStep:
    gaps = [gap for robot in robots for gap in robot.checks.uncommanded.gaps]
    silences = [gap for robot in robots for gap in robot.silences.gaps]
    return UpgradeStep(step.name, round(step.until - step.at, 1), _longest(step, gaps), _longest(step, silences))


def _longest(step: InjectedFault, gaps: Sequence[Gap]) -> float:
    return round(max((gap.seconds for gap in gaps if causes_of((step,), gap)), default=0.0), 2)


async def release_of(python: str) -> str:
    """Return the release that an interpreter has, and the folder of its modules.

    Raises
    ------
    Unavailable
        It has none.
    """
    process = await asyncio.create_subprocess_exec(
        python, "-P", "-c", RELEASE_OF, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
    )
    told, error = await process.communicate()
    if process.returncode:
        raise Unavailable(f"{python} has no release of ppaas: {error.decode(errors='replace')[-300:]}")
    return told.decode().strip()
