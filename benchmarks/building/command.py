"""``ppaas bench building``: plans over the floors of a building, and what robots do in one."""

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from robots.cli.benches import BenchReport, Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = (
    "buildings: plans over floors beside paths on one floor; rides in lifts, after which floor and pose must be "
    "known; docking from random places"
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
    parser.add_argument("--seed", type=int, default=1, help="seed of rides, docks and their buildings (1)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure the parts; a bar that is missed in one is missed by all."""
    wanted = [arguments.only] if arguments.only else list(PARTS)
    parts = {name: Measured.of(PARTS[name](arguments, progress)) for name in wanted}
    return Measured(
        {name: part.result for name, part in parts.items()},
        text="\n\n".join(f"{name}\n{part.text}" for name, part in parts.items()),
        status=max(part.status for part in parts.values()),
    )


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


PARTS: dict[str, Callable[[argparse.Namespace, "Progress"], BenchReport]] = {
    "plans": _plans,
    "rides": _rides,
    "docks": _docks,
}
"""Parts of the bench, by name."""
