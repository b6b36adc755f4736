"""``ppaas bench fig3``: how the time of a plan grows with the length of its path."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import check_plot, draw
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "time over length of the path: one thread here, a container of many cores, and navfn"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the planning time over the path length")
    parser.add_argument("--map", type=Path, help="YAML file or MovingAI map (a warehouse of 120 by 80 m)")
    parser.add_argument("--cores", type=int, default=2, help="of the container (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure paths of all lengths, and draw where that is asked for."""
    import uvloop  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    from benchmarks.planners import grids, path_lengths, tables  # noqa: PLC0415

    check_plot(arguments)
    map_ = path_lengths.default_map() if arguments.map is None else grids.map_from_file(arguments.map)
    told = event_loop.run(path_lengths.measure(map_, arguments.cores, progress), uvloop.new_event_loop)
    if arguments.plot is not None:
        draw(arguments.plot, path_lengths.chart(told))
    return Measured(told, tables.length_rows(told))
