"""``ppaas bench slam``: accuracy, speed and memory of mapping, beside the bars that they have to meet."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from robots.cli.benches import Measured
from robots.cli.output import table
from robots.pictures.figure_file import check_figure

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.mapping.parts.part import SlamOptions

HELP = "mapping: errors, false closures, times, memory and merges, beside the bars that they have to meet"

MOST_SEEDS = 100

PARTS = ("logs", "steps", "graphs", "merging", "pairs", "lifelong", "volume", "push")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.description = (
        "Measures all parts, one after the other on one core, in less than ten minutes. Simulated worlds are mapped, "
        "and each LOG; its true relations are read from the file beside it that ends with .relations."
    )
    parser.add_argument("logs", type=Path, nargs="*", metavar="LOG", help="log of CARMEN, or bag of ROS")
    parser.add_argument(
        "--data", type=Path, metavar="FOLDER",
        help="map the logs of FOLDER/laser/raw, too, and take depth images of FOLDER/depth, as of the folder that "
        "$PPAAS_DATA names",
    )  # fmt: skip
    parser.add_argument(
        "--only", choices=PARTS, metavar="NAME", action="append",
        help=f"part to measure, again for more: {', '.join(PARTS)} (all)",
    )  # fmt: skip
    parser.add_argument(
        "--offices", type=whole(most=MOST_SEEDS), default=1, metavar="N",
        help="number of offices with different furniture and noise (%(default)s)",
    )  # fmt: skip
    parser.add_argument("--no-worlds", action="store_true", help="map and merge recorded logs only")
    parser.add_argument("--equal-corridors", action="store_true", help="map corridors without open doors, too")
    parser.add_argument("--all-pairs", action="store_true", help="try to merge logs, too, and in both directions: slow")
    parser.add_argument(
        "--graphs", type=Path, nargs="+", default=[], metavar="FILE", help="solve graphs in the format of g2o, too"
    )
    parser.add_argument(
        "--false", type=whole(least=0, most=1000), default=60, metavar="N",
        help="number of false closures of a synthetic graph (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--jobs", type=whole(most=os.cpu_count() or 1), default=1, metavar="N",
        help="number of logs that are mapped at once; more than one makes each slower (%(default)s)",
    )  # fmt: skip
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="chart the error and the time after each stage")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the figures with their bars, and the details of each part."""
    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this module
    from benchmarks.mapping.parts import suite  # noqa: PLC0415

    if arguments.plot is not None:
        check_figure(arguments.plot)
    parts = suite.measure(options_of(arguments), arguments.only or (), progress)
    if arguments.plot is not None and "logs" in parts:
        from benchmarks.mapping.parts.suite import write_stages  # noqa: PLC0415

        write_stages(arguments.plot, parts["logs"].results)
    figures = measured([figure for part in parts.values() for figure in part.figures])
    texts = [figures.text, *("\n".join(table(part.rows, tuple(part.rows[0]))) for part in parts.values() if part.rows)]
    result = {**figures.result, **{name: part.results for name, part in parts.items()}}
    return Measured(result, text="\n\n".join(texts))


def options_of(arguments: argparse.Namespace) -> "SlamOptions":
    """Return the options of the parts."""
    from benchmarks.mapping.parts.part import SlamOptions  # noqa: PLC0415 - ``ppaas bench --help`` loads this module

    return SlamOptions(
        tuple(arguments.logs), arguments.data, arguments.offices, not arguments.no_worlds,
        arguments.equal_corridors, tuple(arguments.graphs), arguments.false, arguments.all_pairs, arguments.jobs,
    )  # fmt: skip
