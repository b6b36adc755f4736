"""``ppaas bench slam``: accuracy, speed and memory of mapping a log, offline."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.bounded_numbers import whole
from ppaas.errors import InvalidInput
from robots.cli.benches import Measured
from robots.pictures.figure_file import check_figure

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.mapping.run import SlamJob

HELP = "mapping of logs and of a simulated office, and the solver of pose graphs: errors, times, memory"

MOST_SEEDS = 100
SLOW_SWEEP = 0.1
"""Time of a scan of the slow laser [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.description = (
        "Without LOG, an office is mapped with a fast and with a slow laser. True relations of a log are read from the "
        "file beside it that ends with .relations."
    )
    parser.add_argument("logs", type=Path, nargs="*", metavar="LOG", help="log of CARMEN, or bag of ROS")
    parser.add_argument(
        "--data", type=Path, metavar="FOLDER",
        help="map all logs of FOLDER/laser/raw, too, as of the folder that $PPAAS_DATA names",
    )  # fmt: skip
    parser.add_argument(
        "--offices", type=whole(least=0, most=MOST_SEEDS), default=1, metavar="N",
        help="number of offices with different furniture and noise (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--jobs", type=whole(most=os.cpu_count() or 1), default=1, metavar="N",
        help="number of processes; more than one makes each slower (%(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--graphs", type=Path, nargs="*", metavar="FILE",
        help="measure the solver instead, on synthetic graphs of 11,456 nodes and on graphs in the format of g2o",
    )  # fmt: skip
    parser.add_argument(
        "--live", action="store_true", help="measure single steps instead: scan to pose, search, layers"
    )
    parser.add_argument(
        "--lifelong", action="store_true",
        help="map the office for two hours with mode lifelong instead: memory after each hour, some minutes",
    )  # fmt: skip
    parser.add_argument(
        "--corridors", action="store_true", help="map simulated corridors, too: 1.9 km that look alike, a few minutes"
    )
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="chart the error and the time after each stage")
    parser.add_argument(
        "--false", type=whole(least=0, most=1000), default=60, metavar="N",
        help="number of false closures of a synthetic graph (%(default)s)",
    )  # fmt: skip


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the results, and their table."""
    if arguments.graphs is not None:
        return _measure_graphs(arguments.graphs, arguments.false, progress)
    if arguments.live:
        return _measure_steps(progress)
    if arguments.lifelong:
        return _measure_hours(progress)
    from benchmarks.mapping import suite  # noqa: PLC0415 - ``ppaas bench --help`` loads this module
    from benchmarks.mapping.run import row  # noqa: PLC0415

    if arguments.plot is not None:
        check_figure(arguments.plot)
    jobs = _jobs(arguments)
    task = progress.add_task("map", total=len(jobs))
    results = suite.measure(jobs, arguments.jobs, lambda: progress.advance(task))
    if arguments.plot is not None:
        from benchmarks.mapping.stage_chart import write_stages  # noqa: PLC0415

        write_stages(arguments.plot, results)
    return Measured({"logs": results}, [row(result) for result in results])


def _measure_steps(progress: "Progress") -> Measured:
    from benchmarks.mapping import live  # noqa: PLC0415

    task = progress.add_task("drive, search and build layers", total=3)
    results = live.measure(lambda: progress.advance(task))
    return Measured({"steps": results}, [live.row(result) for result in results])


def _measure_hours(progress: "Progress") -> Measured:
    from benchmarks.mapping.lifelong import next_hour  # noqa: PLC0415

    task = progress.add_task("map for two hours", total=1)
    results = next_hour.measure(lambda: progress.advance(task))
    return Measured({"hours": results}, next_hour.rows(results))


def _measure_graphs(files: list[Path], false: int, progress: "Progress") -> Measured:
    from benchmarks.mapping import graph_solve, graph_suite  # noqa: PLC0415

    task = progress.add_task("solve", total=len(graph_suite.SYNTHETIC) + len(files))
    results = graph_suite.measure(files, false, lambda: progress.advance(task))
    return Measured({"graphs": results}, [graph_solve.row(result) for result in results])


def _jobs(arguments: argparse.Namespace) -> "list[SlamJob]":
    from benchmarks.mapping.run import SlamJob  # noqa: PLC0415

    logs = list(arguments.logs)
    if arguments.data is not None:
        folder = arguments.data / "laser" / "raw"
        found = sorted(folder.glob("*.clf*"))
        if not found:
            raise InvalidInput(f"{folder} has no log: no file *.clf or *.clf.bz2")
        logs += found
    for log in logs:
        if not log.exists():
            raise InvalidInput(f"there is no log {log}")
    jobs = [SlamJob(log) for log in logs]
    for seed in range(arguments.offices):
        jobs += [SlamJob(seed=seed), SlamJob(seed=seed, sweep=SLOW_SWEEP)]
    if arguments.corridors:
        jobs.append(SlamJob(corridors=True))
    if not jobs:
        raise InvalidInput("nothing to map: give a LOG, --data or --offices above 0")
    return jobs
