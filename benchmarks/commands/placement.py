"""``ppaas bench placement``: comparison of balancers, and growth of the master."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.bounded import whole
from robots.cli import event_loop
from robots.cli.benches import Measured
from robots.cli.output import table

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "balancers with the same robots, and how the master grows to thousands of machines"

BALANCERS, GROWTH = PARTS = ("balancers", "growth")

MOST_ROBOTS, MOST_MACHINES = 10_000_000, 100_000


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument(
        "--only",
        choices=PARTS,
        metavar="NAME",
        action="append",
        help=f"part to measure, again for more: {', '.join(PARTS)} (all)",
    )
    parser.add_argument(
        "--large",
        action="store_true",
        help="growth: also 10,000 machines, 200 endpoints and 1,000,000 robots, which takes minutes and 4 GB",
    )
    parser.add_argument(
        "--robots", type=whole(most=MOST_ROBOTS), default=20_000, metavar="N", help="number of robots (%(default)s)"
    )
    parser.add_argument(
        "--machines", type=whole(most=MOST_MACHINES), default=500, metavar="N", help="number of machines (%(default)s)"
    )
    parser.add_argument(
        "--cores", type=whole(most=1024), default=8, metavar="N", help="CPUs of a machine (%(default)s)"
    )
    parser.add_argument(
        "--maps", type=whole(most=MOST_ROBOTS), default=1000, metavar="N", help="number of maps (%(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="seed of the robots (%(default)s)")
    parser.add_argument(
        "--arrivals",
        type=Path,
        metavar="FILE",
        help="recorded arrivals, a JSON object {at, robot, map, cores, stays} a line",
    )
    parser.add_argument(
        "--balancer", action="append", metavar="NAME", help="balancer, again for more (all installed ones)"
    )


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the results of the chosen parts, and their tables."""
    chosen, result, texts = arguments.only or PARTS, dict[str, Any](), list[str]()
    for part, measure_part in ((BALANCERS, _compare_balancers), (GROWTH, _grow)):
        if part in chosen:
            told, rows = measure_part(arguments, progress)
            result |= told
            texts.append("\n".join(table(rows, tuple(rows[0]))))
    return Measured(result, text="\n\n".join(texts))


def _compare_balancers(
    arguments: argparse.Namespace, progress: "Progress"
) -> tuple[dict[str, Any], list[dict[str, str]]]:
    from benchmarks.placement import balancers  # noqa: PLC0415 - ``ppaas bench --help`` loads this
    from engine.master.balancers.registry import BALANCERS as INSTALLED  # noqa: PLC0415

    options = balancers.PlacementOptions(
        arguments.robots, arguments.machines, arguments.cores, arguments.maps, arguments.seed,
        tuple(arguments.balancer or INSTALLED.names()), arguments.arrivals,
    )  # fmt: skip
    told = balancers.measure(options, progress)
    return told, [_row(name, figures) for name, figures in told["balancers"].items()]


def _grow(arguments: argparse.Namespace, progress: "Progress") -> tuple[dict[str, Any], list[dict[str, str]]]:
    import msgspec  # noqa: PLC0415

    from benchmarks.placement import growth  # noqa: PLC0415

    sizes = (*growth.STEPS, growth.LARGE) if arguments.large else growth.STEPS
    grown = event_loop.run(growth.measure(sizes, progress))
    return {"growth": msgspec.to_builtins(grown)}, growth.rows(grown)


def _row(name: str, told: dict[str, Any]) -> dict[str, str]:
    return {
        "balancer": name,
        "placed": f"{told['placed']:,}",
        "rejected": f"{told['rejected']:,}",
        "between machines MB/s": f"{told['cross_machine_mb_per_second']:,.1f}",
        "layers GB": f"{told['layers_gb']:,.1f}",
        "machines in use": f"{told['machines_in_use']:,.0f}",
        "unevenness": f"{told['unevenness']:.2f}",
        "placements /s": f"{told['placements_per_second']:,.0f}",
    }
