"""``ppaas bench building``: plans over the floors of a building, and what robots do in one."""

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from robots.cli.benches import BenchReport, Measured

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.building.hotel.run import HotelCase

HELP = (
    "buildings: plans over floors beside paths on one floor; rides in lifts, after which floor and pose must be "
    "known; docking from random places; whole robots in a hotel"
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--only", choices=tuple(PARTS), help="one part of the bench (all)")
    parser.add_argument("--floors", type=int, default=10, help="number of floors of the plans (10)")
    parser.add_argument("--cells", type=int, default=1024, help="cells along the edge of each floor (1024)")
    parser.add_argument("--queries", type=int, default=1000, help="number of plans (1000)")
    parser.add_argument(
        "--checked", type=int, default=20, help="number of plans that are compared with Dijkstra's (20)"
    )
    parser.add_argument("--rides", type=int, default=1000, metavar="N", help="number of rides in lifts (1000)")
    parser.add_argument("--docks", type=int, default=1000, metavar="N", help="number of docks (1000)")
    parser.add_argument("--robots", type=int, default=20, metavar="N", help="number of robots in the hotel (20)")
    parser.add_argument("--minutes", type=float, default=30.0, help="simulated time of each run of the hotel (30)")
    parser.add_argument("--seeds", type=int, default=5, metavar="N", help="number of seeds of the hotel (5)")
    parser.add_argument("--capacity", type=int, default=2, metavar="N", help="robots that a car of the hotel holds (2)")
    parser.add_argument("--house", type=Path, metavar="FILE", help="building of Open-RMF in place of the hotel")
    parser.add_argument("--picture", type=Path, metavar="FILE.png", help="draw a run of the hotel, and measure nothing")
    parser.add_argument("--seed", type=int, default=1, help="seed of rides, docks and their buildings (1)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure the parts; a bar that is missed in one is missed by all."""
    if arguments.picture is not None:
        return _picture(arguments)
    wanted = [arguments.only] if arguments.only else list(PARTS)
    parts = {name: _measured(PARTS[name](arguments, progress)) for name in wanted}
    return Measured(
        {name: part.result for name, part in parts.items()},
        text="\n\n".join(f"{name}\n{part.text}" for name, part in parts.items()),
        status=max(part.status for part in parts.values()),
    )


def _measured(result: BenchReport | Measured) -> Measured:
    return result if isinstance(result, Measured) else Measured.of(result)


def _plans(arguments: argparse.Namespace, progress: "Progress") -> BenchReport:
    # ``ppaas bench --help`` loads this module.
    from benchmarks.building.plans import measure_plans  # noqa: PLC0415

    task = progress.add_task("plans", total=5)
    return measure_plans(
        arguments.floors, arguments.cells, arguments.queries, arguments.checked, lambda: progress.advance(task)
    )


def _rides(arguments: argparse.Namespace, progress: "Progress") -> BenchReport:
    # ``ppaas bench --help`` loads this module.
    from benchmarks.building import rides  # noqa: PLC0415

    rode = progress.track(rides.measure(arguments.rides, arguments.seed), total=arguments.rides, description="rides")
    return list(rode)[-1]


def _docks(arguments: argparse.Namespace, progress: "Progress") -> BenchReport:
    # ``ppaas bench --help`` loads this module.
    from benchmarks.building.docks import measure_docks  # noqa: PLC0415

    task = progress.add_task("docks", total=arguments.docks)
    return measure_docks(arguments.docks, arguments.seed, lambda: progress.advance(task))


def _hotel(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    # ``ppaas bench --help`` loads this module.
    from benchmarks.building.hotel.measure import measure_hotel  # noqa: PLC0415
    from benchmarks.harness.figures import measured  # noqa: PLC0415

    task = progress.add_task("hotel", total=3 * arguments.seeds)
    return measured(measure_hotel(_case(arguments), arguments.seeds, lambda: progress.advance(task)))


def _picture(arguments: argparse.Namespace) -> Measured:
    # ``ppaas bench --help`` loads this module.
    from benchmarks.building.hotel.recording import write_run  # noqa: PLC0415

    write_run(arguments.picture, _case(arguments), arguments.seed)
    return Measured({"picture": str(arguments.picture)}, text=f"{arguments.picture} is drawn")


def _case(arguments: argparse.Namespace) -> "HotelCase":
    # ``ppaas bench --help`` loads this module.
    from benchmarks.building.hotel.house import hotel, imported  # noqa: PLC0415
    from benchmarks.building.hotel.run import HotelCase  # noqa: PLC0415

    house = hotel() if arguments.house is None else imported(arguments.house)
    return HotelCase(house, arguments.robots, arguments.capacity, 60.0 * arguments.minutes)


PARTS: dict[str, Callable[[argparse.Namespace, "Progress"], BenchReport | Measured]] = {
    "plans": _plans,
    "rides": _rides,
    "docks": _docks,
    "hotel": _hotel,
}
"""Parts of the bench, by name."""
