"""CPU time of a driving robot's container and machine, in turns with and without a recording.

The turns alternate, so that a change of the drive or of the load of the computer falls on both. CPU time is counted,
and not time on the clock, so other work on the computer matters little.
"""

import asyncio
from contextlib import AsyncExitStack
from typing import TYPE_CHECKING, NamedTuple

import psutil

from benchmarks.harness.cloud_under_test import CloudUnderTest, own_cloud
from benchmarks.harness.figures import Figure, median_of
from benchmarks.harness.process_usage import cpu_of, cpu_seconds
from benchmarks.harness.roaming_robot import roaming_robot
from engine.recorder import main as recorder_main
from ppaas.clock import monotonic
from ppaas.maps.generate import office
from robots.sim.courses import CoursePlanner
from robots.sim.simulator import Simulator
from robots.sim.world import World

if TYPE_CHECKING:
    from rich.progress import Progress


ROBOT, MAP = "bench-recorded", "bench-recording"
RECORDINGS = f"/v1/robots/{ROBOT}/recordings"

TURNS, QUICK_TURNS = 5, 1
"""Number of turns with a recording, and of turns without one."""

TURN, QUICK_TURN = 20.0, 3.0
"""Length of a turn [s]."""

MOST_CPU = 3.0
"""Largest share of a core that a recording may take [%]."""


class _Used(NamedTuple):
    """Shares of a core in a turn [%]: of the container, the machine without the recorder, and the recorder."""

    container: float
    machine: float
    recorder: float


async def measure(progress: "Progress", *, quick: bool) -> list[Figure]:
    """Return the figures."""
    async with AsyncExitStack() as stack:
        target = await stack.enter_async_context(own_cloud())
        await _drive(target, stack)
        bench = _Bench(target, QUICK_TURN if quick else TURN)
        await bench.record()  # starts the recorder, which imports its libraries
        for _ in progress.track(range(QUICK_TURNS if quick else TURNS), description="turns"):
            bench.without.append(await bench.turn())
            bench.recorded.append(await bench.record())
        return bench.figures()


async def _drive(target: CloudUnderTest, stack: AsyncExitStack) -> None:
    grid = office(seed=1, width=12.0, height=10.0)
    await target.publish(MAP, grid)
    course = CoursePlanner(grid, 1).choose(1, 3)[0]
    world = World(grid, 1)
    body = world.add_robot(course.start)
    await target.register(ROBOT, MAP, course.start, cores=1.0)
    running = asyncio.create_task(Simulator(world).run())
    stack.callback(running.cancel)
    await stack.enter_async_context(roaming_robot(target.url, target.token, ROBOT, body, course))
    await asyncio.sleep(2.0)


class _Bench:
    def __init__(self, target: CloudUnderTest, seconds: float) -> None:
        self._target, self._seconds = target, seconds
        self.without: list[_Used] = []
        self.recorded: list[_Used] = []
        self._sizes: list[float] = []

    async def turn(self) -> _Used:
        """Return what a turn takes."""
        assert self._target.pid is not None
        containers = await self._target.rest.items("/v1/containers")
        pids = {one["pid"] for one in containers}
        before, writer, began = cpu_seconds(self._target.pid, pids), self._recorder(), monotonic()
        await asyncio.sleep(self._seconds)
        after, written, seconds = cpu_seconds(self._target.pid, pids), self._recorder(), monotonic() - began
        machine = after["machine"] - before["machine"] - (written - writer)
        shares = (after["containers"] - before["containers"], machine, written - writer)
        return _Used(*(100.0 * share / seconds for share in shares))

    async def record(self) -> _Used:
        """Return what a turn with a recording takes."""
        rest = self._target.rest
        recording = (await rest.post(RECORDINGS, {"seconds": 3600.0}))["id"]
        used = await self.turn()
        await rest.post(f"{RECORDINGS}/{recording}/stop", {})
        size = (await rest.get(f"{RECORDINGS}/{recording}"))["size"]
        self._sizes.append(size / 1e6 * 60.0 / self._seconds)
        return used

    def _recorder(self) -> float:
        """Return the CPU time of the recorder so far [s]; 0 before it was started."""
        for process in psutil.Process(self._target.pid).children(recursive=True):
            if recorder_main.__name__ in process.cmdline():
                return cpu_of(process)
        return 0.0

    def figures(self) -> list[Figure]:
        """Return the figures of all turns."""
        part = "recording"
        without = [one.container + one.machine for one in self.without]
        added = [one.container + one.machine - before for one, before in zip(self.recorded, without, strict=True)]
        writing = [one.recorder for one in self.recorded]
        total = [one + other for one, other in zip(added, writing, strict=True)]
        return [
            median_of(part, "clone and machine, without a recording", without, "%", yardstick=True),
            median_of(part, "added to them by a recording", added, "%", note="JSON of each message, batches"),
            median_of(part, "recorder", writing, "%", note="CDR, compression, files"),
            median_of(part, "share of a core of a recording", total, "%", limit=MOST_CPU, note="both together"),
            median_of(part, "size of a minute", self._sizes[1:], "MB"),
        ]
