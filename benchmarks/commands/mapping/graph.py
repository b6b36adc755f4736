"""``ppaas bench graph``: CPU time and accuracy of the solver of pose graphs."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.bounded_numbers import whole
from ppaas.errors import InvalidInput
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "pose graphs solved from odometry and from their solution, with and without false closures"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.description = "Solves a synthetic graph of 11,456 nodes, whose true poses are known, and graphs in files."
    parser.add_argument("files", type=Path, nargs="*", metavar="FILE", help="graph in the format of g2o")
    parser.add_argument(
        "--false", type=whole(least=0, most=1000), default=60, metavar="N",
        help="number of false closures of a second synthetic graph (%(default)s)",
    )  # fmt: skip


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the results, and their table."""
    from benchmarks.mapping import graph_solve  # noqa: PLC0415 - ``ppaas bench --help`` loads this module
    from ppaas.mapping.graph.g2o import parse_g2o  # noqa: PLC0415
    from ppaas.mapping.graph.solver import Robust  # noqa: PLC0415

    missing = [str(file) for file in arguments.files if not file.is_file()]
    if missing:
        raise InvalidInput(f"there is no file {missing[0]}")
    cases = [(0, Robust.NONE), (0, Robust.GRADUATED), (arguments.false, Robust.SCALING)]
    cases.append((arguments.false, Robust.GRADUATED))
    task = progress.add_task("solve", total=len(cases) + len(arguments.files))
    graph_solve.warm_kernels()
    results = []
    for false, robust in cases:
        results.append(graph_solve.measure(*graph_solve.walks(false), robust))
        progress.advance(task)
    for file in arguments.files:
        with file.open(encoding="utf-8") as lines:
            graph = parse_g2o(lines)
        results.append(graph_solve.measure(file.stem, graph, None, Robust.GRADUATED))
        progress.advance(task)
    return Measured({"graphs": results}, [graph_solve.row(result) for result in results])
