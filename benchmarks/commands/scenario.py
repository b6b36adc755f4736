"""``ppaas bench scenario``: runs the queries of a MovingAI scenario, and checks the lengths of the paths."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "every query of a MovingAI scenario: times, and number of wrong lengths"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("scenario", type=Path, metavar="FILE.scen")
    parser.add_argument("--map", type=Path, metavar="FILE.map", help="map (beside the scenario, of the same name)")
    parser.add_argument("--planner", default="dijkstra", help="name of an installed planner (%(default)s)")
    parser.add_argument("--limit", type=int, metavar="N", help="only the first N queries (all)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Run the queries."""
    from benchmarks.planners import scenario, tables  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    told = scenario.measure(arguments.scenario, arguments.map, arguments.planner, arguments.limit, progress)
    return Measured(told, tables.scenario_rows(told))
