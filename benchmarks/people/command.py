"""``ppaas bench people``: robots that track, count and follow people together, beside bars and other rules."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ppaas.bounded import above_zero, whole
from ppaas.errors import InvalidInput
from robots.cli.benches import Measured
from robots.cli.output import table
from robots.pictures.figure_file import check_figure

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.people.options import PeopleOptions
    from benchmarks.people.runs.job import PeopleJob

HELP = "people: exact counts, identities, following and handovers of several robots, beside bars and other rules"

MOST_ROBOTS, MOST_PEOPLE, MOST_SEEDS, MOST_MINUTES, MOST_JOBS = 50, 200, 100, 120.0, 64
ROBOTS, PEOPLE, MAPS = (2, 5, 10), (1, 5, 20), ("office", "warehouse")
PARTS = ("coordination", "faults", "detector", "legs", "coordinator", "bandwidth")
POLICIES = ("paper", "nearest", "single")
DETECTIONS = ("camera", "laser", "truth")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.description = (
        "Simulates robots and people faster than real time: each robot has the nodes of its clone, and the coordinator "
        "is the one of the cloud. The whole table takes hours: --keep makes it resumable."
    )
    parser.add_argument(
        "--only", choices=PARTS, metavar="NAME", action="append",
        help=f"part to measure, again for more: {', '.join(PARTS)} (all)",
    )  # fmt: skip
    parser.add_argument("--robots", type=whole(most=MOST_ROBOTS), nargs="+", default=ROBOTS, metavar="N",
                        help="numbers of robots (2 5 10)")  # fmt: skip
    parser.add_argument("--people", type=whole(least=0, most=MOST_PEOPLE), nargs="+", default=PEOPLE, metavar="N",
                        help="numbers of people (1 5 20)")  # fmt: skip
    parser.add_argument("--maps", nargs="+", default=MAPS, metavar="NAME",
                        help="office, warehouse, or map files (both)")  # fmt: skip
    parser.add_argument("--minutes", type=above_zero(MOST_MINUTES), default=10.0, metavar="M",
                        help="simulated minutes of each run (%(default)s)")  # fmt: skip
    parser.add_argument("--seeds", type=whole(most=MOST_SEEDS), default=5, metavar="N",
                        help="number of seeds, from 0 on (%(default)s)")  # fmt: skip
    parser.add_argument(
        "--policies",
        nargs="+",
        choices=POLICIES,
        default=POLICIES,
        metavar="NAME",
        help="rules to compare: paper, nearest (without hysteresis), single (one robot follows) (all)",
    )
    parser.add_argument("--detections", choices=DETECTIONS, default="camera",
                        help="depth images, scans, or true positions with noise (%(default)s)")  # fmt: skip
    parser.add_argument("--size", default="320x240", metavar="WxH", help="size of depth images (%(default)s)")
    parser.add_argument("--jobs", type=whole(most=MOST_JOBS), default=os.cpu_count() or 1, metavar="N",
                        help="number of processes (%(default)s)")  # fmt: skip
    parser.add_argument("--keep", type=Path, metavar="FILE",
                        help="store the result of each run in a file, and do not repeat stored runs: so a long bench "
                        "may be interrupted")  # fmt: skip
    parser.add_argument("--picture", type=Path, metavar="OUT.png", help="draw the first run, and do nothing else")
    parser.add_argument("--data", type=Path, metavar="FOLDER", help="take depth images of FOLDER/depth, too")
    parser.add_argument("--quick", action="store_true", help="take few samples")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the figures with their bars, and the details of each part."""
    from benchmarks.harness.figures import measured  # noqa: PLC0415 - ``ppaas bench --help`` loads this module
    from benchmarks.people import suite  # noqa: PLC0415

    options = options_of(arguments)
    if arguments.picture is not None:
        return _draw(arguments.picture, options.jobs[0])
    parts = suite.measure(options, arguments.only or (), progress)
    figures = measured([figure for part in parts.values() for figure in part.figures])
    texts = [figures.text, *("\n".join(table(part.rows, tuple(part.rows[0]))) for part in parts.values() if part.rows)]
    result = {**figures.result, **{name: part.results for name, part in parts.items()}}
    return Measured(result, text="\n\n".join(texts))


def options_of(arguments: argparse.Namespace) -> "PeopleOptions":
    """Return the options of the parts.

    Raises
    ------
    InvalidInput
        The size is not one.
    InvalidMap
        A map cannot be read.
    """
    from benchmarks.people.options import PeopleOptions  # noqa: PLC0415 - as above

    size = _size(arguments.size)
    jobs = tuple(_jobs(arguments, size))
    return PeopleOptions(jobs, arguments.jobs, arguments.keep, size, 0, arguments.data, arguments.quick)


def _jobs(arguments: argparse.Namespace, size: tuple[int, int]) -> "list[PeopleJob]":
    from benchmarks.harness.maps import read_map  # noqa: PLC0415 - as above
    from benchmarks.people.runs.job import PeopleJob  # noqa: PLC0415

    return [
        PeopleJob(name, grid, robots, people, arguments.minutes, policy, arguments.detections, size, seed)
        for name, grid in ((name, read_map(name)) for name in dict.fromkeys(arguments.maps))
        for policy in dict.fromkeys(arguments.policies)
        for robots in dict.fromkeys(arguments.robots)
        for people in dict.fromkeys(arguments.people)
        for seed in range(arguments.seeds)
    ]


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal() and 16 <= int(width) <= 1280 and 16 <= int(height) <= 1024):
        raise InvalidInput(f"--size takes WIDTHxHEIGHT in pixels, such as 320x240, not {text!r}")
    return int(width), int(height)


def _draw(path: Path, job: "PeopleJob") -> Measured:
    check_figure(path)
    from benchmarks.people.runs.picture import write_picture  # noqa: PLC0415 - as above

    result = write_picture(path, job)
    return Measured(result, [{name: str(value) for name, value in result.items()}])
