"""Shared arguments of planner benches: grid, goal, numbers of threads, and the file of a chart."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput, InvalidParameter

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.planners.grids import Grid


def add_grid_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of a grid; ``grid_of`` returns it."""
    grid = parser.add_mutually_exclusive_group(required=True)
    grid.add_argument("--map", type=Path, metavar="FILE", help="YAML file, MovingAI map, or PGM of a costmap")
    grid.add_argument("--empty", type=int, metavar="N", help="N×N free cells")
    grid.add_argument(
        "--random", type=float, nargs=2, metavar=("N", "PERCENT"), help="N×N cells, PERCENT of them blocked"
    )
    grid.add_argument("--maze", type=int, nargs="+", metavar="N", help="N×N cells [and the WIDTH of corridors, 1]")
    parser.add_argument("--tiles", type=int, default=1, metavar="N", help="N by N copies of the grid, side by side")


def add_goal_argument(parser: argparse.ArgumentParser) -> None:
    """Add the argument of a goal; ``goal_of`` returns it."""
    parser.add_argument("--goal", type=int, nargs=2, metavar=("R", "C"), help="row, column (near the middle)")


def add_threads_argument(parser: argparse.ArgumentParser) -> None:
    """Add the argument of numbers of threads; ``threads_of`` returns them."""
    parser.add_argument(
        "--threads", type=_numbers, metavar="1,2", help="numbers of threads (1, and the number of CPUs)"
    )


def grid_of(arguments: argparse.Namespace) -> "Grid":
    """Return the grid of the arguments.

    Raises
    ------
    InvalidInput
        There is no such grid.
    """
    from benchmarks.planners import grids  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    return grids.tiled(_single(arguments), arguments.tiles)


def _single(arguments: argparse.Namespace) -> "Grid":
    from benchmarks.planners import grids  # noqa: PLC0415

    if arguments.map is not None:
        return grids.from_file(arguments.map)
    if arguments.empty is not None:
        return grids.empty(arguments.empty)
    if arguments.random is not None:
        size, percent = arguments.random
        if size != int(size):
            raise InvalidInput(f"the first number of --random must be a whole number of cells, not {size:g}")
        return grids.random(int(size), percent)
    if len(arguments.maze) > 2:
        raise InvalidInput(f"--maze takes one number or two, not {len(arguments.maze)}")
    return grids.maze(*arguments.maze)


def goal_of(arguments: argparse.Namespace) -> tuple[int, int] | None:
    """Return the goal; None for a cell near the middle."""
    return None if arguments.goal is None else (arguments.goal[0], arguments.goal[1])


def threads_of(arguments: argparse.Namespace) -> list[int]:
    """Return the numbers of threads."""
    from benchmarks.planners.timing import cpus  # noqa: PLC0415

    return arguments.threads or sorted({1, cpus()})


def _numbers(text: str) -> list[int]:
    numbers = [int(number) if number.isdecimal() else 0 for number in text.split(",")]
    if min(numbers) < 1:
        raise InvalidParameter(f"numbers of threads must be whole numbers from 1 up, not {text!r}")
    return list(dict.fromkeys(numbers))


def check_plot(arguments: argparse.Namespace) -> None:
    """Raise before the measurement if no chart can be written to the file of ``--plot``."""
    if arguments.plot is not None:
        from robots.pictures.figure_file import check_figure  # noqa: PLC0415

        check_figure(arguments.plot)


def draw(path: Path, chart: Any) -> None:
    """Write a chart, given by title, lines and axes, to a file."""
    from robots.pictures.line_chart import write_chart  # noqa: PLC0415

    write_chart(path, *chart)


def tell_left_out(told: dict[str, Any], progress: "Progress") -> None:
    """Print the peers that were not measured, with the reasons."""
    for peer, reason in told["left_out"].items():
        progress.console.print(f"{peer} is left out: {reason}", markup=False, highlight=False, soft_wrap=True)
