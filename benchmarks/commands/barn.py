"""``ppaas bench barn``: drives a Jackal by a local planner through the worlds of the BARN benchmark."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.bounded import above_zero, whole
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.navigation.barn.run import BarnResult

HELP = "a robot without a map among cylinders: success rate, time, and clearance"

MOST_RUNS, MOST_JOBS, MOST_RADIUS = 10_000, 1_024, 1.0
WORST = 5
"""Number of the worst worlds that the table lists."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("file", type=Path, metavar="WORLDS.json")
    parser.add_argument(
        "--runs", type=whole(most=MOST_RUNS), default=10, metavar="N", help="runs of each world (%(default)s)"
    )
    parser.add_argument("--seed", type=whole(least=0), default=0, metavar="N",
                        help="seed of all noise; equal seeds give equal runs (%(default)s)")  # fmt: skip
    parser.add_argument("--planner", default="mppi", metavar="NAME", help="local planner (%(default)s)")
    parser.add_argument("--noise", choices=("none", "nominal", "hard"), default="nominal",
                        help="noise of sensors and motors (%(default)s)")  # fmt: skip
    parser.add_argument(
        "--radius", type=above_zero(MOST_RADIUS), metavar="M", help="radius of the cylinders (that of the file)"
    )
    parser.add_argument("--worlds", type=_numbers, default=(), metavar="3,9", help="numbers of worlds (all)")
    parser.add_argument("--jobs", type=whole(most=MOST_JOBS), default=os.cpu_count() or 1, metavar="N",
                        help="number of processes (%(default)s)")  # fmt: skip
    parser.add_argument("--picture", type=Path, metavar="OUT.png", help="draw the first run of the first world")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the summary of all runs, and its table."""
    from benchmarks.navigation.barn import run  # noqa: PLC0415
    from benchmarks.navigation.barn.worlds import read_worlds  # noqa: PLC0415
    from ppaas.controllers.registry import CONTROLLERS  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    CONTROLLERS.load(arguments.planner)  # report an unknown name before any process is started
    worlds = read_worlds(arguments.file, arguments.worlds, arguments.radius)
    options = run.BarnOptions(arguments.runs, arguments.planner, arguments.noise, arguments.seed, arguments.jobs)
    if arguments.picture is not None:
        _draw(arguments.picture, run.jobs_of(worlds, options)[0])
    task = progress.add_task(f"{len(worlds)} worlds", total=len(worlds) * arguments.runs)
    results = run.measure(worlds, options, lambda: progress.advance(task))
    return Measured(run.summary(results), _rows(results))


def _draw(path: Path, job: Any) -> None:
    from benchmarks.navigation.barn.picture import write_picture  # noqa: PLC0415
    from robots.pictures.figure_file import check_figure  # noqa: PLC0415

    check_figure(path)
    write_picture(path, job)


def _rows(results: "list[BarnResult]") -> list[dict[str, str]]:
    from benchmarks.navigation.barn.run import summary  # noqa: PLC0415

    of: dict[int, list[BarnResult]] = {}
    for result in results:
        of.setdefault(result.world, []).append(result)
    told = {number: summary(runs) for number, runs in of.items()}
    worst = sorted(told, key=lambda number: (told[number]["metric"], told[number]["min_clearance"]))[:WORST]
    return [_row("all", summary(results)), *(_row(f"world {number}", told[number]) for number in worst)]


def _row(name: str, told: dict[str, Any]) -> dict[str, str]:
    shares = {share: f"{told[share]:.1%}" for share in ("success", "collision", "timeout")}
    return {
        "worlds": name,
        "runs": f"{told['runs']:,}",
        **shares,
        "metric": f"{told['metric']:.4f}",
        "AT/OT": "-" if told["at_over_ot"] is None else f"{told['at_over_ot']:.2f}",
        "least clearance m": f"{told['min_clearance']:.3f}",
    }


def _numbers(text: str) -> tuple[int, ...]:
    if not all(number.isdecimal() for number in text.split(",")):
        raise argparse.ArgumentTypeError(f"worlds must be whole numbers separated by commas, not {text!r}")
    return tuple(dict.fromkeys(map(int, text.split(","))))
