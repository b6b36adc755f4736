"""``ppaas bench fig3``: planning time over path length, as in Fig. 3 of the paper."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from benchmarks.planners.grid_arguments import check_plot, draw
from robots.cli import event_loop
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "planning time over path length: threads of this process, a container of several cores, and navfn"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the planning time over the path length")
    parser.add_argument("--map", type=Path, help="YAML file or MovingAI map (a generated warehouse of 120 by 80 m)")
    parser.add_argument("--cores", type=int, default=2, help="cores of the container (%(default)s)")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Measure paths of all lengths, and draw the chart if it is requested."""
    import uvloop  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    from benchmarks.planners import path_lengths, tables  # noqa: PLC0415
    from robots.client.map_files import read_map_file  # noqa: PLC0415

    check_plot(arguments)
    map_ = path_lengths.default_map() if arguments.map is None else read_map_file(arguments.map)
    told = event_loop.run(path_lengths.measure(map_, arguments.cores, progress), uvloop.new_event_loop)
    if arguments.plot is not None:
        draw(arguments.plot, path_lengths.chart(told))
    return Measured(told, tables.length_rows(told))
