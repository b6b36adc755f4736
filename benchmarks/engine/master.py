"""Placement rate of the master, and its state after it was killed during placements.

The master is that of a cloud, with its service, its balancer and its store on disk. Another process simulates the
machines: each has a real control link, accepts orders and reports running containers, but starts none.
"""

import asyncio
import contextlib
import tempfile
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import msgspec
from rich.progress import Progress

from benchmarks.engine.options import EngineOptions
from benchmarks.harness.figures import Figure
from benchmarks.harness.json_process import JsonProcess, json_process
from benchmarks.placement import machines_process, master_process
from ppaas.clock import monotonic
from ppaas.decoding import converted

PART = "master"
BALANCERS = ("ppaas", "first_fit")
NONE = "none"
RATE_LIMIT = 2000.0
"""Smallest acceptable placement rate [1/s]."""
FEW_MACHINES, FEW_PLACEMENTS = 10, 200

SAID_OF = 20
"""Number of machines that are configured before the master is killed."""

KEEP_EVERY = 10
"""Every tenth container has a checkpoint before the master is killed."""


class PlacedRobot(msgspec.Struct, frozen=True):
    """Placement of a robot.

    Parameters
    ----------
    machine, container : str
        Names of its machine and container.
    goes_on : str
        Container whose checkpoint it continues; empty if none.
    kept : bool
        Whether the container stored a checkpoint.
    """

    machine: str
    container: str
    goes_on: str
    kept: bool = False


async def measure(options: EngineOptions, progress: Progress) -> list[Figure]:
    """Place all robots with each balancer and without a master; then kill a master during placements and restart it."""
    machines = min(options.machines, FEW_MACHINES) if options.quick else options.machines
    robots = min(options.placements, FEW_PLACEMENTS) if options.quick else options.placements
    task = progress.add_task(f"placing {robots} containers on {machines} machines", total=len(BALANCERS) + 2)
    figures = []
    for balancer in (*BALANCERS, NONE):
        placed = await _placed(balancer, robots, machines)
        figures.append(_rate_figure(balancer, placed, robots, machines))
        progress.advance(task)
    figures += await _killed(robots, machines)
    progress.remove_task(task)
    return figures


def _rate_figure(balancer: str, placed: dict[str, float], robots: int, machines: int) -> Figure:
    rate = round(robots / placed["seconds"])
    if balancer == NONE:
        note = "the same orders by the same links, each machine in turn, no master and no store"
        return Figure(PART, "orders, without a master", rate, "/s", yardstick=True, note=note)
    each = 1e6 * placed["cpu"] / robots
    note = f"{robots:,} on {machines:,} machines, until each machine has said that it runs; {each:.0f} µs of CPU each"
    return Figure(PART, f"placements by {balancer}", rate, "/s", limit=RATE_LIMIT, floor=True, note=note)


@contextlib.asynccontextmanager
async def _master(folder: Path, balancer: str, robots: int, machines: int) -> AsyncIterator[JsonProcess]:
    async with json_process(master_process, str(folder), balancer, str(robots)) as master:
        await master.hear()
        await master.ask({"do": "wait", "machines": machines})
        yield master


@contextlib.asynccontextmanager
async def _machines(machines: int, keep_every: int) -> AsyncIterator[tuple[Path, JsonProcess]]:
    """Run simulated machines; yield the folder of their cloud, and their process."""
    with tempfile.TemporaryDirectory(prefix="b-", ignore_cleanup_errors=True) as name:  # sockets need a short path
        async with json_process(machines_process, name, str(machines), str(keep_every)) as carrying:
            yield Path(name), carrying


async def _placed(balancer: str, robots: int, machines: int) -> dict[str, float]:
    """Place all robots; return ``seconds`` and the master's CPU time ``cpu`` [s]."""
    async with _machines(machines, 0) as (folder, _), _master(folder, balancer, robots, machines) as master:
        placed: dict[str, float] = await master.ask({"do": "place", "robots": robots})
        return placed


async def _killed(robots: int, machines: int) -> list[Figure]:
    """Kill a master during placements; restart it, and reconnect all robots."""
    said_of = min(SAID_OF, machines // 2)
    async with _machines(machines, KEEP_EVERY) as (folder, carrying):
        async with _master(folder, BALANCERS[0], robots, machines) as master:
            said = await master.ask({"do": "configure", "machines": said_of})
            await master.say({"do": "place", "robots": robots})
            await _placed_half(carrying, robots)
            await master.kill()
        began = monotonic()
        before = await _told(carrying)
        async with _master(
            folder, BALANCERS[0], robots, machines - 1
        ) as master:  # the one that was removed is not let in
            await master.ask({"do": "place", "robots": robots})
            took = monotonic() - began
            return survived(before, await _told(carrying), said, await master.ask({"do": "state"}), took)


async def _placed_half(carrying: JsonProcess, robots: int) -> None:
    while True:
        if await carrying.ask("count") >= robots // 2:
            return
        await asyncio.sleep(0.01)


async def _told(carrying: JsonProcess) -> dict[str, PlacedRobot]:
    return converted(await carrying.ask("told"), dict[str, PlacedRobot])


def survived(
    before: dict[str, PlacedRobot],
    after: dict[str, PlacedRobot],
    said: dict[str, Any],
    still: dict[str, Any],
    took: float,
) -> list[Figure]:
    """Return the figures of a killed master, from the placements and settings before and after.

    Parameters
    ----------
    before, after : dict of str to PlacedRobot
        Placements of the robots by the killed master, and by the next.
    said, still : dict
        Settings of the machines before and after.
    took : float
        Time from the kill until all robots were placed [s].
    """
    made_anew = sum(robot in after for robot in before)
    kept = {robot: ordered.container for robot, ordered in before.items() if ordered.kept}
    goes_on = sum(after[robot].goes_on == container for robot, container in kept.items() if robot in after)
    settings = sum(still["settings"].get(machine) == settings for machine, settings in said["settings"].items())
    held = settings + (still["removed"] == said["removed"])
    wrong = {name: view for name, view in still["settings"].items() if view.get("draining")}
    misplaced = sum(ordered.machine in wrong or ordered.machine in still["removed"] for ordered in after.values())
    why = "master killed by -9 while it placed, started again on its folder"
    return [
        Figure(PART, "placements made anew", made_anew, "robots", limit=len(before), floor=True,
               note=f"{why}; robots come again, as their sockets do"),
        Figure(PART, "checkpoints gone on from", goes_on, "robots", limit=len(kept), floor=True,
               note="of those that were kept before the kill"),
        Figure(PART, "settings of machines kept", held, "machines", limit=len(said["settings"]) + 1, floor=True,
               note="labels, limits, draining, and which was removed"),
        Figure(PART, "placed where none may be", misplaced, "robots", limit=0, note="drained or removed machines"),
        Figure(PART, "from the kill until all are placed", round(took, 2), "s", note=f"{len(after):,} robots"),
    ]  # fmt: skip
