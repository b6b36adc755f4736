"""``ppaas bench lifts``: robots of a hotel that share lifts, beside first-come-first-served and a queueing bound."""

import argparse
import statistics
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.progress import Progress

    from benchmarks.harness.figures import Figure
    from benchmarks.lifts.hotel import Hotel, LiftsResult

HELP = "robots that share the lifts of a hotel: goals beside first-come-first-served, waits beside a bound"

SEEDS, QUICK_SEEDS, QUICK_SECONDS = 5, 1, 300.0

DEADLOCK = 600.0
"""Age of a request from which it counts as a deadlock [s]."""

PART = "lifts"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--robots", type=int, default=20, help="number of robots (%(default)s)")
    parser.add_argument("--floors", type=int, default=3, help="number of floors (%(default)s)")
    parser.add_argument("--lifts", type=int, default=2, help="number of lifts (%(default)s)")
    parser.add_argument("--capacity", type=int, default=2, help="number of robots that a car holds (%(default)s)")
    parser.add_argument("--minutes", type=float, default=30.0, help="simulated time of each run (%(default)g)")
    parser.add_argument("--quick", action="store_true", help="little time: a check that it runs, not for comparison")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the figures."""
    from benchmarks.harness.figures import measured  # noqa: PLC0415
    from benchmarks.lifts.hotel import FirstCome, Hotel, SharedLifts, simulate  # noqa: PLC0415 - loaded for --help

    seconds = QUICK_SECONDS if arguments.quick else 60.0 * arguments.minutes
    hotel = Hotel(arguments.robots, arguments.floors, arguments.lifts, arguments.capacity, seconds)
    broken = Hotel(arguments.robots, arguments.floors, arguments.lifts, arguments.capacity, seconds, seconds / 3.0)
    seeds = range(QUICK_SEEDS if arguments.quick else SEEDS)
    kinds = ((hotel, SharedLifts), (hotel, FirstCome), (broken, SharedLifts))
    ours, first, rerouted = (
        [simulate(place, policy, seed) for seed in progress.track(seeds, description="lifts")]
        for place, policy in kinds
    )
    return measured(_figures(hotel, ours, first, rerouted))


def _figures(
    hotel: "Hotel", ours: "Sequence[LiftsResult]", first: "Sequence[LiftsResult]", broken: "Sequence[LiftsResult]"
) -> "list[Figure]":
    from benchmarks.harness.figures import Figure  # noqa: PLC0415

    goals, others = sum(run.goals for run in ours), sum(run.goals for run in first)
    wait = statistics.fmean(wait for run in ours for wait in run.waits)
    bound = least_wait(hotel, statistics.fmean(drive for run in ours for drive in run.drives))
    most = max(number for run in ours for number in run.boarded.values())
    late = sum(run.longest_open > DEADLOCK for run in (*ours, *broken))
    return [
        Figure(PART, "goals", goals, "", note=f"rides that ended, of {len(ours)} seeds"),
        Figure(PART, "goals, first come first served", others, "", yardstick=True, note="one robot a trip"),
        Figure(PART, "goals over first come first served", goals / others, "", limit=1.3, floor=True),
        Figure(PART, "mean wait", wait, "s", note="from the request to boarding"),
        Figure(PART, "bound of the mean wait", bound, "s", yardstick=True, note="closed queue, cars always full"),
        Figure(PART, "mean wait over its bound", wait / bound, "", limit=1.5),
        Figure(PART, "robots in a car, at most", most, "", limit=hotel.capacity),
        Figure(PART, "requests open for 10 minutes", late, "", limit=0),
        Figure(
            PART,
            "re-routed after a lift breaks",
            max(run.rerouted for run in broken),
            "s",
            limit=5.0,
            note="until no robot waits for it",
        ),
    ]


def least_wait(hotel: "Hotel", drive: float) -> float:
    """Return a bound below which no schedule brings the mean wait [s].

    Robots and lifts are a closed queue. A ride takes at least the passages of its doors, and a share of a trip in a
    full car; so the lifts serve at most so many robots a second, and a robot that neither drives nor rides waits. With
    few robots it waits at least until an idle car has opened.

    Parameters
    ----------
    hotel : Hotel
    drive : float
        Mean time of a drive between two rides [s].
    """
    from benchmarks.lifts.hotel import PASSAGE, STOREY  # noqa: PLC0415
    from ppaas.buildings.lifts.simulated import LiftModel  # noqa: PLC0415

    model = LiftModel()
    pairs = [abs(start - end) for start in range(hotel.floors) for end in range(hotel.floors) if start != end]
    trip = STOREY * statistics.fmean(pairs) / model.speed + model.speed / model.acceleration + 2.0 * model.doors
    service = 2.0 * PASSAGE + trip / hotel.capacity
    ride = 2.0 * PASSAGE + trip
    return max(hotel.robots * service / hotel.lifts - drive - ride, model.doors)
