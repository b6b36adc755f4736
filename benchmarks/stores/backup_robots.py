"""Times between the commands of driving robots, while their cloud is backed up and while it is not, in turns."""

import asyncio
import contextlib
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec
import numpy as np

from benchmarks.harness.cloud_under_test import LINGER, logged_in
from benchmarks.harness.roaming_robot import RoamingRobot, roaming_robot
from ppaas.clock import monotonic
from ppaas.errors import Unavailable
from ppaas.maps.generate import warehouse
from robots import cli
from robots.demo.cloud_process import CloudProcess
from robots.sim.courses import CoursePlanner
from robots.sim.simulator import Simulator
from robots.sim.world import World

if TYPE_CHECKING:
    from rich.progress import Progress

MAP, SIDES = "driven", (24.0, 16.0)
"""Map of the robots, and its width and height [m]."""

WARM = 15.0
"""Time from the first commands until the first turn [s]."""


class CommandGaps(msgspec.Struct, frozen=True):
    """Times between two commands of all robots [ms].

    Parameters
    ----------
    seconds : float
        Time for which the robots drove [s].
    commands : int
        Number of the times.
    p50, p99, most : float
    """

    seconds: float
    commands: int
    p50: float
    p99: float
    most: float


class DrivenBackups(msgspec.Struct, frozen=True):
    """Robots that drove while their cloud was backed up, and while it was not.

    Parameters
    ----------
    robots, turns : int
    quiet, backed_up : CommandGaps
        Without and with a backup.
    """

    robots: int
    turns: int
    quiet: CommandGaps
    backed_up: CommandGaps


async def drive(folder: Path, robots: int, turns: int, progress: "Progress") -> DrivenBackups:
    """Start a cloud with the filled data folder ``folder/data``, let robots drive, and back it up, in turns.

    Raises
    ------
    Unavailable
        The cloud does not start, or a backup fails.
    """
    grid = warehouse(3, *SIDES)
    world = World(grid, robots)
    quiet, backed_up = _Turns(), _Turns()
    async with contextlib.AsyncExitStack() as stack:
        cloud = await stack.enter_async_context(CloudProcess(folder=folder, arguments=("--linger", str(LINGER))))
        target = await logged_in(cloud)
        await target.publish(MAP, grid)
        simulating = asyncio.create_task(Simulator(world).run())
        stack.callback(simulating.cancel)
        roamers = []
        for number, course in enumerate(CoursePlanner(grid, robots).choose(robots, 2)):
            await target.register(name := f"driven-{number}", MAP, course.start)
            robot = roaming_robot(target.url, target.token, name, world.add_robot(course.start), course)
            roamers.append(await stack.enter_async_context(robot))
        await asyncio.gather(*(roamer.drives.wait() for roamer in roamers))
        await asyncio.sleep(WARM)
        for turn in progress.track(range(turns), description="robots drive, with and without a backup"):
            with backed_up.of(roamers):
                await _back_up(folder, str(turn))
            with quiet.of(roamers):
                await asyncio.sleep(backed_up.seconds - quiet.seconds)
    return DrivenBackups(robots, turns, quiet.gaps(), backed_up.gaps())


class _Turns:
    """Times between commands in some turns."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._gaps: list[float] = []

    @contextlib.contextmanager
    def of(self, roamers: Sequence[RoamingRobot]) -> Iterator[None]:
        """Take the times between the commands in the block."""
        for roamer in roamers:
            roamer.gaps.clear()
        began = monotonic()
        yield
        self.seconds += monotonic() - began
        for roamer in roamers:
            self._gaps += roamer.gaps

    def gaps(self) -> CommandGaps:
        """Return the percentiles; infinite without commands."""
        found = 1e3 * np.array(self._gaps or [np.inf])
        p50, p99, most = (round(float(np.percentile(found, percent, method="higher")), 1) for percent in (50, 99, 100))
        return CommandGaps(round(self.seconds, 1), len(self._gaps), p50, p99, most)


async def _back_up(folder: Path, name: str) -> None:
    """Make a whole backup, in a new repository."""
    command = [sys.executable, "-m", cli.__name__, "backup", "create", str(folder / f"driven-{name}")]
    process = await asyncio.create_subprocess_exec(
        *command, "--data", str(folder / "data"), "--json", stdout=asyncio.subprocess.DEVNULL
    )
    if await process.wait():
        raise Unavailable(f"the backup ended with status {process.returncode}")
