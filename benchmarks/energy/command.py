"""``ppaas bench energy``: a fleet works on few chargers for a day, beside the bound of a linear program."""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ppaas.bounded import above_zero, whole
from ppaas.energy.battery import Battery
from ppaas.energy.sites import Sites
from ppaas.tasks.options import PlaceHold
from ppaas.tasks.orders import RobotNow
from ppaas.tasks.reach import SPEED, straight
from ppaas.tasks.records import Place, Task
from ppaas.tasks.rehearsal import Rehearsal
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "robots work for a day on few chargers, led by the dispatcher; beside it the bound of a linear program"

HALL = 120.0, 80.0
"""Size of the hall [m]."""

STATIONS = 16
"""Number of places where tasks pick and drop."""

PER_METRE, PER_SECOND = 6e-5, 1e-5
"""Charge that a metre and a second cost: 7 h of driving."""

SLICE = 30.0
"""Time between two looks at the tasks that wait [s]."""

LEAST = 0.9
"""Least part of the bound that must be done."""

HANDLING = 30.0
"""Time that a robot is loaded, and unloaded [s]."""

PERIOD = 5.0
"""Least time between two decisions [s]."""


@dataclass(frozen=True, slots=True)
class ChargingFleet:
    """Robots with their batteries, chargers, and places of tasks."""

    robots: dict[str, RobotNow]
    sites: Sites
    places: list[Place]
    gain: float

    @classmethod
    def of(cls, arguments: argparse.Namespace, rng: np.random.Generator) -> "ChargingFleet":
        """Return a fleet of a size, at random places with random charges."""
        gain = 1.0 / (60.0 * arguments.charge_minutes)
        robots = {
            f"r{number:03d}": RobotNow(_place(rng), battery=Battery(float(charge), PER_METRE, PER_SECOND, gain))
            for number, charge in enumerate(rng.uniform(0.3, 1.0, arguments.robots))
        }
        step = HALL[0] / arguments.chargers
        chargers: dict[str, Place] = {f"c{n}": ((n + 0.5) * step, 0.0, 0.0) for n in range(arguments.chargers)}
        return cls(robots, Sites(chargers), [_place(rng) for _ in range(STATIONS)], gain)


def _place(rng: np.random.Generator) -> Place:
    return float(rng.uniform(0.0, HALL[0])), float(rng.uniform(0.0, HALL[1])), 0.0


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
    pairs, rehearsal = work(fleet, seconds, arguments.waiting, rng, progress)
    took = time.perf_counter() - begun
    done = [task for task in rehearsal.tasks.values() if task.kind == "pick_drop" and task.state == "done"]
    charged = sum(task.trip == "charge" and task.state == "done" for task in rehearsal.tasks.values())
    charges = [battery.charge for battery in rehearsal.batteries.values() if battery is not None]
    most = bound(fleet, pairs, seconds, sum(charges))
    ratio, stranded = len(done) / most, len(rehearsal.stranded)
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
        "seconds": round(took, 1),
    }
    text = (
        f"{len(done)} tasks done, {ratio:.3f} of the bound of {most:.0f}; {stranded} robots stranded; {charged} times "
        f"charged; least charge at the end {min(charges):.2f}; simulated in {took:.0f} s"
    )
    return Measured(report, text=text, status=int(stranded > 0 or ratio < LEAST))


def work(
    fleet: ChargingFleet, seconds: float, waiting: int, rng: np.random.Generator, progress: "Progress"
) -> tuple[list[tuple[int, int]], Rehearsal]:
    """Lead the fleet, while so many tasks wait at any time; return the places of all tasks, and the rehearsal."""
    rehearsal = Rehearsal([], fleet.robots, straight, 0.0, sites=fleet.sites, period=PERIOD)
    bar = progress.add_task("hours", total=seconds)
    pairs: list[tuple[int, int]] = []
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
        progress.update(bar, completed=rehearsal.now)
    return pairs, rehearsal


def bound(fleet: ChargingFleet, pairs: Sequence[tuple[int, int]], seconds: float, left: float) -> float:
    """Return the number of tasks of this mix that no plan exceeds which leaves as much charge, even one that knows all.

    The linear program counts moves: loaded ones of tasks, empty ones between places, and ones to and from chargers.
    As many moves end at a place as begin there, but for one of each robot. All together have the time of the robots,
    the energy of the batteries and the chargers, and the time of the chargers, a visit of which fills one battery.
    """
    from scipy.optimize import linprog  # noqa: PLC0415 - takes a third of a second

    chargers = list(fleet.sites.chargers.values())
    places = [*fleet.places, *chargers]
    number, stations, robots = len(places), len(fleet.places), len(fleet.robots)
    ways = np.array([[straight(one, other) for other in places] for one in places])
    mix = np.zeros((number, number))
    np.add.at(mix, tuple(np.array(pairs).T), 1.0 / len(pairs))
    # Unknowns: the number of tasks, empty moves, and the time at each charger.
    empty, none = number * number, np.zeros(len(chargers))
    metres = np.concatenate([[float((mix * ways).sum())], ways.ravel(), none])
    at_charger = np.concatenate([np.zeros(1 + empty), none + 1.0])
    leaves, arrives = np.repeat(np.eye(number), number, axis=1), np.tile(np.eye(number), number)
    balance = (mix.sum(1) - mix.sum(0))[:, np.newaxis]
    flow = np.concatenate([balance, leaves - arrives, np.zeros((number, len(chargers)))], axis=1)
    visits = np.concatenate(
        [np.zeros((len(chargers), 1)), -arrives[stations:], fleet.gain * np.eye(len(chargers))], axis=1
    )
    handling = np.concatenate([[2.0 * HANDLING], np.zeros(empty), none])
    times, energies = metres / SPEED + handling + at_charger, metres * PER_METRE - at_charger * fleet.gain
    start = sum(robot.battery.charge for robot in fleet.robots.values() if robot.battery is not None)
    least = robots * seconds * PER_SECOND
    limits = [np.full(2 * number, float(robots)), none, np.array([robots * seconds, start - least - left])]
    most = np.concatenate([np.full(1 + empty, np.inf), none + seconds])
    found = linprog(
        -np.eye(1, len(most))[0],
        np.vstack([flow, -flow, visits, times, energies]),
        np.concatenate(limits),
        bounds=np.stack([np.zeros(len(most)), most], 1),
        method="highs",
    )
    assert found.success, found.message
    return float(-found.fun)
