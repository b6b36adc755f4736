"""``ppaas bench goals``: sends a simulated robot to goals in a map with pedestrians."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.bounded import whole
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

    from benchmarks.navigation.goals.run import GoalsJob

HELP = "a robot among pedestrians: reached goals, and contacts with people and walls"

MOST_GOALS, MOST_PEOPLE, MOST_JOBS = 100_000, 1_000, 1_024
TOUR = 10
"""Number of consecutive goals of one robot."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--map", action="append", default=[], metavar="NAME|FILE",
                        help="office (the default), warehouse, a YAML file, or the PGM of a costmap; again for "
                        "more maps")  # fmt: skip
    parser.add_argument("--goals", type=whole(most=MOST_GOALS), default=100, metavar="N",
                        help=f"goals in each map, {TOUR} consecutive ones for each robot (%(default)s)")  # fmt: skip
    parser.add_argument("--people", type=whole(least=0, most=MOST_PEOPLE), default=10, metavar="N",
                        help="pedestrians in each map (%(default)s)")  # fmt: skip
    parser.add_argument("--planner", metavar="NAME", help="local planner (the default of robots)")
    parser.add_argument(
        "--told", action="store_true", help="publish the positions of people to the robot, on the topic people"
    )
    parser.add_argument(
        "--set", action="append", default=[], metavar="NODE.NAME=VALUE", help="set a parameter of a node"
    )
    parser.add_argument("--seed", type=whole(least=0), default=0, metavar="N",
                        help="random seed; equal seeds give equal drives (%(default)s)")  # fmt: skip
    parser.add_argument("--jobs", type=whole(most=MOST_JOBS), default=os.cpu_count() or 1, metavar="N",
                        help="number of processes (%(default)s)")  # fmt: skip
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the first drive in the first map")
    parser.add_argument(
        "--drive", type=whole(least=0), metavar="N", help="only the drive of this number in each map, from 0 on"
    )
    parser.add_argument("--keep", type=Path, metavar="FILE",
                        help="store the result of each drive in a file, and do not repeat stored drives: so a long "
                        "bench may be interrupted")  # fmt: skip


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the summaries of each map and of all goals, and their table."""
    from benchmarks.navigation.goals import run  # noqa: PLC0415 - ``ppaas bench --help`` loads this

    jobs = _jobs(arguments)
    if arguments.plot is not None:
        _draw(arguments.plot, jobs[0])
    task = progress.add_task(f"{len(jobs)} drives", total=len(jobs))
    results = run.measure(jobs, arguments.jobs, lambda: progress.advance(task), arguments.keep)
    names = dict.fromkeys(job.name for job in jobs)
    told = {name: run.summary([result for result in results if result.map == name]) for name in names}
    total = run.summary(results)
    rows = [_row(name, each) for name, each in {**told, "all": total}.items()]
    return Measured({"people": arguments.people, "planner": jobs[0].controller, "maps": told, **total}, rows)


def _jobs(arguments: argparse.Namespace) -> "list[GoalsJob]":
    """Return the drives of all robots in all maps.

    Raises
    ------
    NotFound, InvalidParameter
        A plug-in or a parameter is unknown or invalid; raised before any process is started.
    """
    from benchmarks.harness.maps import read_map  # noqa: PLC0415
    from benchmarks.navigation.goals.run import GoalsJob, Trip  # noqa: PLC0415
    from ppaas.clone.plugins import DEFAULT_CONTROLLER  # noqa: PLC0415
    from ppaas.errors import InvalidInput  # noqa: PLC0415

    parameters: dict[str, dict[str, Any]] = {}
    for node, name, value in map(_parameter, arguments.set):
        parameters.setdefault(node, {})[name] = value
    tours = [min(TOUR, arguments.goals - first) for first in range(0, arguments.goals, TOUR)]
    jobs = [
        GoalsJob(
            name, grid, arguments.people, tour, arguments.planner or DEFAULT_CONTROLLER, parameters,
            arguments.seed, drive, arguments.told,
        )
        for name, grid in ((name, read_map(name)) for name in dict.fromkeys(arguments.map or ["office"]))
        for drive, tour in enumerate(tours)
        if arguments.drive in (None, drive)
    ]  # fmt: skip
    if not jobs:
        raise InvalidInput(f"--drive must be below {len(tours)}, not {arguments.drive}")
    Trip(jobs[0])
    return jobs


def _parameter(text: str) -> tuple[str, str, Any]:
    """Return node, name and value; a value that is not JSON is a string."""
    import msgspec  # noqa: PLC0415

    from ppaas.errors import InvalidInput  # noqa: PLC0415

    path, _, value = text.partition("=")
    node, _, name = path.rpartition(".")
    if not node or not value:
        raise InvalidInput(f"--set takes NODE.NAME=VALUE, such as amcl.max_particles=1000, not {text!r}")
    try:
        return node, name, msgspec.json.decode(value)
    except msgspec.DecodeError:
        return node, name, value


def _draw(path: Path, job: "GoalsJob") -> None:
    from benchmarks.navigation.goals.picture import write_picture  # noqa: PLC0415
    from robots.pictures.figure_file import check_figure  # noqa: PLC0415

    check_figure(path)
    write_picture(path, job)


def _row(name: str, told: dict[str, Any]) -> dict[str, str]:
    """Return the row of a map; reasons of failures are only in the JSON."""
    return {"map": name} | {
        key: "-" if value is None else f"{value:,}" for key, value in told.items() if key != "failures"
    }
