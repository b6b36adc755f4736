"""Growth of the master: the same figures at several sizes of a cloud, so that it is seen what grows with the size.

Each size is simulated in a process of its own, and adopted by a new master in another.
"""

import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from benchmarks.harness.json_process import json_process
from benchmarks.placement import growth_process
from benchmarks.placement.simulated_cloud import Cost, Sizes
from engine.processes.heartbeats import BEAT_PERIOD
from ppaas.decoding import converted

if TYPE_CHECKING:
    from rich.progress import Progress

DEAD = 15.0
"""Time after which a silent connection counts as dead, by default [s]; a robot is pinged three times as often."""

STEPS = (Sizes(100, 2, 10_000), Sizes(1_000, 20, 100_000))
LARGE = Sizes(10_000, 200, 1_000_000)
"""Sizes of the clouds: of the default run, and one more."""

ROUND_TRIPS = 3.0 / DEAD
"""Frequency at which an endpoint measures the round trip of each robot, and the master is told if it changed [Hz]."""


class Grown(msgspec.Struct):
    """Result of a cloud of one size.

    Parameters
    ----------
    machines, endpoints, robots : int
        Its size.
    places : int
        Number of robots that were connected at the end.
    rejected : int
        Number of robots for which no machine had room.
    costs : dict of str to Cost
        CPU time of the master by kind of event.
    memory_mb : float
        Memory of a master that has adopted all of them [MB].
    """

    machines: int
    endpoints: int
    robots: int
    places: int
    rejected: int
    costs: dict[str, Cost]
    memory_mb: float

    def mean(self, *kinds: str) -> float:
        """Return the sum of the mean CPU times of some kinds of events [s]."""
        return sum(self.costs[kind].mean for kind in kinds)

    @property
    def at_rest(self) -> tuple[float, float]:
        """Cores that the master takes while robots only stand: for heartbeats of machines, and for round trips."""
        beats = self.machines * self.mean("heartbeat, decoding", "heartbeat") / BEAT_PERIOD
        return beats, self.places * self.mean("round trip") * ROUND_TRIPS


async def measure(sizes: tuple[Sizes, ...], progress: "Progress") -> list[Grown]:
    """Return the results of clouds of several sizes."""
    return [await _grown(size, progress) for size in sizes]


async def _grown(size: Sizes, progress: "Progress") -> Grown:
    with tempfile.TemporaryDirectory(prefix="placement-") as folder:
        file, numbers = Path(folder) / "registrations", (size.machines, size.endpoints, size.robots)
        text = f"{size.robots:,} robots on {size.machines:,} machines"
        grown = await _run(progress, text, size.robots, "grow", str(file), *map(str, numbers))
        adopted = await _run(progress, f"{text}, taken over", size.machines, "adopt", str(file))
    costs = grown["costs"] | adopted["costs"]
    told = {"places": grown["places"], "rejected": grown["rejected"], "memory_mb": adopted["memory_mb"]}
    return converted(asdict(size) | told | {"costs": costs}, Grown)


async def _run(progress: "Progress", text: str, total: int, *arguments: str) -> dict[str, Any]:
    """Run a process to its end, and show its progress; return its result."""
    task = progress.add_task(text, total=total)
    async with json_process(growth_process, *arguments) as process:
        while "result" not in (told := await process.hear()):
            progress.update(task, completed=told["done"])
    progress.remove_task(task)
    result: dict[str, Any] = told["result"]
    return result


# -- table -------------------------------------------------------------------------------------------------------------

ROWS: dict[str, Callable[[Grown], str]] = {
    "robots connected at the end": lambda grown: f"{grown.places:,}",
    "robots without room": lambda grown: f"{grown.rejected:,}",
    "placements, until reported as ready": lambda grown: f"{1.0 / grown.mean('place', 'launched', 'ready'):,.0f} /s",
    "of it the choice of the machine": lambda grown: _micro(grown.mean("place")),
    "robot roams to another endpoint": lambda grown: _micro(grown.mean("roam", "round trip")),
    "robot goes": lambda grown: _micro(grown.mean("release")),
    "robot goes while machines drain": lambda grown: _micro(grown.mean("release while draining")),
    "robot refused, no room": lambda grown: _micro(grown.mean("refusal, no room")),
    "robot refused, no such labels": lambda grown: _micro(grown.mean("refusal, no labels")),
    "longest garbage collection": lambda grown: _milli(grown.costs["collection"].longest),
    "map of no robot published": lambda grown: _milli(grown.mean("map without robots")),
    "map of most robots published": lambda grown: _milli(grown.mean("map of most robots")),
    "machine lost": lambda grown: _milli(grown.mean("machine lost")),
    "endpoint lost, its robots come to others": lambda grown: _milli(grown.mean("endpoint lost")),
    "cores for heartbeats of machines": lambda grown: f"{grown.at_rest[0]:.2f}",
    "cores for round trips of robots": lambda grown: f"{grown.at_rest[1]:.2f}",
    "take-over, all containers": lambda grown: f"{_takeover(grown):,.2f} s",
    "of it decoding": lambda grown: f"{grown.costs['registration, decoding'].seconds:,.2f} s",
    "of it garbage collection": lambda grown: f"{grown.costs['adoption, collection'].seconds:,.2f} s",
    "memory of the master": lambda grown: f"{grown.memory_mb:,.0f} MB",
    "of it each robot": lambda grown: f"{1e6 * grown.memory_mb / max(grown.places, 1):,.0f} bytes",
}
"""Cells of the table by the name of the row."""


def rows(grown: list[Grown]) -> list[dict[str, str]]:
    """Return the table: a row for each figure, a column for each size."""
    return [
        {"master": name, **{f"{one.machines:,} machines": cell(one) for one in grown}} for name, cell in ROWS.items()
    ]


def _takeover(grown: Grown) -> float:
    return grown.costs["registration, decoding"].seconds + grown.costs["adoption"].seconds


def _micro(seconds: float) -> str:
    return f"{1e6 * seconds:,.0f} µs"


def _milli(seconds: float) -> str:
    return f"{1e3 * seconds:,.2f} ms"
