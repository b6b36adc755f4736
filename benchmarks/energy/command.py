"""``ppaas bench energy``: a fleet works on few chargers for a day, beside the bound of a linear program."""

import argparse
import time
from collections import Counter
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.energy.bound import PARTS, bound
from benchmarks.energy.fleet import HANDLING, ChargingFleet
from ppaas.bounded import above_zero, whole
from ppaas.tasks.options import PlaceHold
from ppaas.tasks.reach import straight
from ppaas.tasks.records import Task
from ppaas.tasks.rehearsal import Rehearsal
from robots.cli.benches import Measured
from robots.cli.output import table

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "robots work for a day on few chargers, led by the dispatcher; beside it the bound of a linear program"

SLICE = 30.0
"""Time between two looks at the tasks that wait, and at what robots do [s]."""

LEAST = 0.9
"""Least part of the bound that must be done."""

PERIOD = 2.0
"""Least time between two decisions [s]: the master decides within a second once a robot is free."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--robots", type=whole(most=1000), default=100, metavar="N", help="robots (%(default)s)")
    parser.add_argument("--chargers", type=whole(most=200), default=10, metavar="N", help="chargers (%(default)s)")
    parser.add_argument("--hours", type=above_zero(240.0), default=24.0, help="simulated time (%(default)s)")
    parser.add_argument(
        "--charge-minutes", type=above_zero(1000.0), default=40.0, metavar="MINUTES",
        help="time in which a charger fills an empty battery (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--waiting", type=whole(most=1000), default=40, metavar="N", help="tasks that wait (%(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of places, charges and tasks (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Run the bench; the exit status is 1 if a robot is stranded, or too little of the bound is done."""
    rng = np.random.default_rng(arguments.seed)
    fleet, seconds = ChargingFleet.of(arguments, rng), 3600.0 * arguments.hours
    begun = time.perf_counter()
    pairs, rehearsal, parts = work(fleet, seconds, arguments.waiting, rng, progress)
    took = time.perf_counter() - begun
    done = [task for task in rehearsal.tasks.values() if task.kind == "pick_drop" and task.state == "done"]
    charged = sum(task.trip == "charge" and task.state == "done" for task in rehearsal.tasks.values())
    charges = [battery.charge for battery in rehearsal.batteries.values() if battery is not None]
    most, best = bound(fleet, pairs, seconds, sum(charges))
    ratio, stranded = len(done) / most, len(rehearsal.stranded)
    times = times_of_task(parts, len(fleet.robots) * seconds / max(1, len(done)))
    least = {part: best[part] / most for part in PARTS}
    longest = max((task.begun - task.created for task in done if task.begun is not None), default=0.0)
    report: dict[str, Any] = {
        "robots": len(fleet.robots),
        "chargers": len(fleet.sites.chargers),
        "hours": arguments.hours,
        "tasks": len(done),
        "bound": round(most, 1),
        "ratio": round(ratio, 4),
        "stranded": stranded,
        "charges": charged,
        "least_charge": round(min(charges), 3),
        "longest_wait": round(longest, 1),
        "seconds_of_task": {part: round(seconds, 2) for part, seconds in times.items()},
        "seconds_of_bound": {part: round(seconds, 2) for part, seconds in least.items()},
        "seconds": round(took, 1),
    }
    text = (
        f"{len(done)} tasks done, {ratio:.3f} of the bound of {most:.0f}; {stranded} robots stranded; {charged} times "
        f"charged; least charge at the end {min(charges):.2f}; no task waited for more than {longest:.0f} s; simulated "
        f"in {took:.0f} s"
    )
    return Measured(report, text=f"{_table(times, least)}\n{text}", status=int(stranded > 0 or ratio < LEAST))


def times_of_task(parts: Mapping[str, int], seconds: float) -> dict[str, float]:
    """Return the time of a robot that each part of a task takes in the mean [s], of all that a task takes."""
    return {part: seconds * parts.get(part, 0) / max(1, sum(parts.values())) for part in PARTS}


def _table(times: Mapping[str, float], least: Mapping[str, float]) -> str:
    both = {part: (times[part], least[part]) for part in PARTS} | {"in all": (sum(times.values()), sum(least.values()))}
    rows = [
        {"a task takes": part, "robots": f"{fleet:.1f} s", "bound": f"{best:.1f} s", "more": f"{fleet - best:.1f} s"}
        for part, (fleet, best) in both.items()
    ]
    return "\n".join(table(rows, tuple(rows[0])))


def work(
    fleet: ChargingFleet, seconds: float, waiting: int, rng: np.random.Generator, progress: "Progress"
) -> tuple[list[tuple[int, int]], Rehearsal, Counter[str]]:
    """Lead the fleet, while so many tasks wait at any time.

    Returns
    -------
    pairs : list of tuple of int
        Places of all tasks.
    rehearsal : Rehearsal
    parts : Counter of str
        How often a robot was seen at each part of its work.
    """
    rehearsal = Rehearsal([], fleet.robots, straight, 0.0, sites=fleet.sites, period=PERIOD)
    bar = progress.add_task("hours", total=seconds)
    pairs: list[tuple[int, int]] = []
    parts: Counter[str] = Counter()
    holds = (PlaceHold(seconds=HANDLING),) * 2
    while rehearsal.now < seconds:
        queued = sum(task.state == "queued" for task in rehearsal.open_tasks)
        for _ in range(waiting - queued):
            pick, drop = map(int, rng.choice(len(fleet.places), 2, replace=False))
            places = fleet.places[pick], fleet.places[drop]
            rehearsal.add(
                Task(id=f"t{len(pairs):06d}", kind="pick_drop", places=places, holds=holds, created=rehearsal.now)
            )
            pairs.append((pick, drop))
        rehearsal.run(min(rehearsal.now + SLICE, seconds))
        parts.update(parts_of(rehearsal.open_tasks, len(fleet.robots)))
        progress.update(bar, completed=rehearsal.now)
    return pairs, rehearsal, parts


def parts_of(tasks: Iterable[Task], robots: int) -> Counter[str]:
    """Return how many robots are at which part of their work."""
    parts = Counter(_part(task) for task in tasks if task.robot)
    parts["idle"] = robots - parts.total()
    return parts


def _part(task: Task) -> str:
    if task.trip == "charge":
        return "to chargers" if task.holding is None else "charging"
    if task.holding is not None:
        return "handling"
    return "empty" if task.state == "assigned" else "loaded"
