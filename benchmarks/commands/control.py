"""``ppaas bench control``: computing time of the control cycles of local planners."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.bounded import whole
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.navigation.control_cycles import Cycles

HELP = "computing time of the control cycles of each local planner, on the way to the same goals"

MOST_GOALS, MOST_THREADS, MOST_SECONDS, MOST_OTHERS = 1_000, 1_024, 3_600, 1_000


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--planner", action="append", default=[], metavar="NAME", help="local planner (all)")
    parser.add_argument("--map", default="office", metavar="NAME|FILE",
                        help="office, warehouse, a YAML file, or the PGM of a costmap (%(default)s)")  # fmt: skip
    parser.add_argument(
        "--goals", type=whole(most=MOST_GOALS), default=10, metavar="N", help="number of goals (%(default)s)"
    )
    parser.add_argument("--seed", type=whole(least=0), default=0, metavar="N",
                        help="seed of the goals (%(default)s)")  # fmt: skip
    parser.add_argument(
        "--threads",
        type=whole(most=MOST_THREADS),
        default=1,
        metavar="N",
        help="largest number of threads (%(default)s)",
    )
    parser.add_argument(
        "--heavy", action="store_true", help="how far bases with slow brakes drive past a goal, instead of times"
    )
    parser.add_argument(
        "--clone", type=whole(most=MOST_SECONDS), metavar="SECONDS",
        help="CPU time of a whole clone for each second of a drive of this length, by cause, instead of planners alone",
    )  # fmt: skip
    parser.add_argument(
        "--others", type=whole(least=0, most=MOST_OTHERS), default=0, metavar="N",
        help="with --clone, number of other robots on the map (%(default)s)",
    )  # fmt: skip
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the times of all cycles")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the results, and their table."""
    from benchmarks.harness.maps import read_map  # noqa: PLC0415
    from benchmarks.navigation import control_cycles as cycles  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    if arguments.heavy:
        return _heavy(tuple(arguments.planner), progress)
    if arguments.clone:
        return _clone(arguments.clone, arguments.others, progress)
    chosen = cycles.setups(tuple(arguments.planner))
    if arguments.plot is not None:
        from robots.pictures.figure_file import check_figure  # noqa: PLC0415

        check_figure(arguments.plot)
    task = progress.add_task(f"drive through {arguments.map}", total=len(chosen) * arguments.goals)
    told = cycles.measure(
        read_map(arguments.map), chosen, arguments.goals,
        seed=arguments.seed, threads=arguments.threads, done=lambda: progress.advance(task),
    )  # fmt: skip
    if arguments.plot is not None:
        _draw(arguments.plot, told)
    rows = cycles.summary(told)
    title = {"map": arguments.map, "window": cycles.WINDOW, "rate": cycles.RATE, "threads": arguments.threads}
    return Measured({**title, "planners": rows}, [{name: str(value) for name, value in row.items()} for row in rows])


def _heavy(names: tuple[str, ...], progress: "Progress") -> Measured:
    from benchmarks.navigation import heavy_bases  # noqa: PLC0415

    task = progress.add_task("stop heavy bases", total=None)
    rows = heavy_bases.measure(names, done=lambda: progress.advance(task))
    return Measured({"bases": rows}, [{name: str(value) for name, value in row.items()} for row in rows])


def _clone(seconds: int, others: int, progress: "Progress") -> Measured:
    from benchmarks.navigation import clone_cpu  # noqa: PLC0415

    task = progress.add_task("drive with a whole clone", total=None)
    spent = clone_cpu.measure(seconds, others, done=lambda: progress.advance(task))
    rows = clone_cpu.rows(spent)
    result = {"seconds": seconds, "others": others, "commands": spent.commands, "ms_per_second": rows}
    return Measured(result, [{name: str(value) for name, value in row.items()} for row in rows])


def _draw(path: Path, told: "list[Cycles]") -> None:
    import numpy as np  # noqa: PLC0415

    from robots.pictures.line_chart import Axis, Line, write_chart  # noqa: PLC0415

    parts = np.linspace(0.0, 100.0, 201)
    lines = [
        Line(cycles.setup.name, list(zip(parts, 1e3 * np.percentile(cycles.seconds, parts), strict=True)))
        for cycles in told
    ]
    write_chart(
        path, "Control cycles", lines, Axis("share of all cycles [%]"), Axis("take at most [ms]", logarithmic=True)
    )
