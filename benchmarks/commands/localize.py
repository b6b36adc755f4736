"""``ppaas bench localize``: accuracy and recovery of localization, and time of an update."""

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.bounded import above_zero, whole
from ppaas.errors import InvalidInput
from robots.cli.benches import Measured

if TYPE_CHECKING:
    from rich.progress import Progress

HELP = "localization of a simulated robot or a recording: errors, distance until a lost robot is found, update times"

MOST_RUNS, MOST_JOBS, MOST_METRES, MOST_PEOPLE, MOST_MINUTES = 10_000, 1_024, 100_000.0, 100, 1_440.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("recording", type=Path, nargs="?", metavar="BAG|LOG",
                        help="recording to replay: a bag of ROS, or a log of CARMEN (a simulated robot)")  # fmt: skip
    parser.add_argument("--map", metavar="NAME|FILE",
                        help="office (the default), warehouse, a YAML file, or the PGM of a costmap; for a recording "
                        "with true poses, a map is made of every other scan by default")  # fmt: skip
    parser.add_argument("--same", action="store_true",
                        help="make the map of all scans of a recording, also of those that are replayed")  # fmt: skip
    parser.add_argument("--drift", type=above_zero(1.0), default=0.0, metavar="PART",
                        help="relative noise to add to the odometry of a recording, 0.02 for 2 %%")  # fmt: skip
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the paths of a recording")
    bag = parser.add_argument_group("bags of ROS", "default: what the transforms and the odometry of the bag say")
    bag.add_argument("--scan-topic", metavar="TOPIC", help="play the scans of this topic alone, as /scan_front")
    bag.add_argument("--odom-frame", metavar="FRAME", help="frame of the odometry, as odom_combined")
    bag.add_argument("--base-frame", metavar="FRAME", help="frame of the robot, as robot1/base_footprint")
    bag.add_argument("--map-frame", metavar="FRAME", help="frame of the true poses (map)")
    parser.add_argument(
        "--runs", type=whole(most=MOST_RUNS), default=20, metavar="N", help="number of runs (%(default)s)"
    )
    parser.add_argument("--metres", type=above_zero(MOST_METRES), default=200.0, metavar="M",
                        help="distance of a run (%(default)g)")  # fmt: skip
    lost = parser.add_mutually_exclusive_group()
    lost.add_argument("--kidnap", action="store_true", help="kidnap the robot, and count metres from there")
    lost.add_argument("--global", action="store_true", dest="anywhere", help="start with an unknown pose")
    lost.add_argument("--jam", type=whole(most=MOST_PEOPLE), default=0, metavar="PEOPLE",
                      help="crowd PEOPLE around the robot for 80 s, and count metres from there")  # fmt: skip
    lost.add_argument("--stand", type=above_zero(MOST_MINUTES), default=0.0, metavar="MINUTES",
                      help="let the robot stand still for MINUTES")  # fmt: skip
    lost.add_argument("--creep", type=above_zero(MOST_MINUTES), default=0.0, metavar="MINUTES",
                      help="let the robot drive at 1 cm/s and 0.01 rad/s at most for MINUTES")  # fmt: skip
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="set a parameter of amcl")
    parser.add_argument("--seed", type=whole(least=0), default=0, metavar="N",
                        help="random seed; equal seeds give equal runs (%(default)s)")  # fmt: skip
    parser.add_argument("--jobs", type=whole(most=MOST_JOBS), default=os.cpu_count() or 1, metavar="N",
                        help="number of processes (%(default)s)")  # fmt: skip
    parser.add_argument("--update", action="store_true", help="measure the time of one update instead")
    parser.add_argument("--particles", type=_numbers, default=(2_000, 20_000), metavar="2000,20000")
    parser.add_argument("--threads", type=_numbers, default=(1, 2), metavar="1,2")


def measure(arguments: argparse.Namespace, progress: "Progress") -> Measured:
    """Return the results, and their table."""
    from benchmarks.harness.maps import read_map  # noqa: PLC0415 - so here and below: ``ppaas bench --help`` loads this

    if arguments.recording is not None:
        told = _play(arguments, progress)
        return Measured(told, [_texts(told)])
    of_bags = (arguments.scan_topic, arguments.odom_frame, arguments.base_frame, arguments.map_frame)
    if arguments.plot is not None or arguments.drift or arguments.same or any(of_bags):
        raise InvalidInput("--plot, --drift, --same, topics and frames are only for a recording: give a bag or a log")
    arguments.map = arguments.map or "office"
    grid = read_map(arguments.map)
    if arguments.update:
        from benchmarks.localization import update  # noqa: PLC0415

        rows = update.measure(grid, arguments.particles, arguments.threads)
        return Measured({"map": arguments.map, "updates": rows}, [_texts(row) for row in rows])
    told = _drive(arguments, grid, progress)
    return Measured(told, [_texts(told)])


def _drive(arguments: argparse.Namespace, grid: Any, progress: "Progress") -> dict[str, Any]:
    from benchmarks.localization import run  # noqa: PLC0415
    from benchmarks.localization.run import Kind, LocalizationJob  # noqa: PLC0415
    from ppaas.localization.parameters import AmclParameters  # noqa: PLC0415
    from ppaas.parameters import read_parameters  # noqa: PLC0415

    asked: dict[Kind, Any] = {
        "kidnap": arguments.kidnap, "global": arguments.anywhere, "jam": arguments.jam,
        "stand": arguments.stand, "creep": arguments.creep,
    }  # fmt: skip
    kind: Kind = next((kind for kind, wanted in asked.items() if wanted), "track")
    parameters = dict(map(_parameter, arguments.set))
    read_parameters(AmclParameters, "amcl", parameters)  # report errors before any process is started
    given = (grid, kind, arguments.metres, parameters, arguments.seed)
    minutes = arguments.stand or arguments.creep
    jobs = [LocalizationJob(*given, run, arguments.jam, minutes) for run in range(arguments.runs)]
    task = progress.add_task(f"{kind} in {arguments.map}", total=len(jobs))
    results = run.measure(jobs, arguments.jobs, lambda: progress.advance(task))
    return {"map": arguments.map, "kind": kind, **run.summary(results)}


def _play(arguments: argparse.Namespace, progress: "Progress") -> dict[str, Any]:
    from benchmarks.harness.maps import read_map  # noqa: PLC0415
    from benchmarks.localization import replay  # noqa: PLC0415
    from benchmarks.localization.replay import drifting, map_of, write_picture  # noqa: PLC0415
    from robots.recordings.reader import read_recording  # noqa: PLC0415
    from robots.recordings.recording import RecordedFrames  # noqa: PLC0415

    if arguments.kidnap or arguments.jam or arguments.stand or arguments.creep or arguments.update:
        raise InvalidInput("--kidnap, --jam, --stand, --creep and --update cannot be used with a recording")
    if arguments.plot is not None:
        from robots.pictures.figure_file import check_figure  # noqa: PLC0415

        check_figure(arguments.plot)
    frames = RecordedFrames(arguments.scan_topic, arguments.odom_frame, arguments.base_frame, arguments.map_frame)
    recording = read_recording(arguments.recording, frames)
    if not recording.has_odometry:
        raise InvalidInput(f"{arguments.recording} has no odometry, which localization needs")
    for note in recording.notes:
        progress.console.print(f"note: {note}", markup=False, highlight=False)
    looks = recording.looks
    whole_drive = arguments.map is not None or arguments.same
    grid = read_map(arguments.map) if arguments.map else map_of(looks if whole_drive else looks[::2])
    # Scans of which the map is made are not replayed.
    scans = range(len(looks)) if whole_drive else range(1, len(looks), 2)
    task = progress.add_task(f"play {arguments.recording}", total=len(looks))
    played = replay.play(
        drifting(recording, arguments.drift, arguments.seed), grid, dict(map(_parameter, arguments.set)),
        scans=scans, anywhere=arguments.anywhere, done=lambda: progress.advance(task),
    )  # fmt: skip
    if arguments.plot is not None:
        write_picture(arguments.plot, grid, played)
    kind = "global" if arguments.anywhere else "track"
    return {
        "recording": str(arguments.recording), "map": arguments.map or "of the recording", "kind": kind,
        "drift": arguments.drift, **replay.summary(played, anywhere=arguments.anywhere),
    }  # fmt: skip


def _texts(row: dict[str, Any]) -> dict[str, str]:
    return {name: "" if value is None else str(value) for name, value in row.items()}


def _parameter(text: str) -> tuple[str, Any]:
    """Return name and value; a value that is not JSON is a string."""
    import msgspec  # noqa: PLC0415

    name, _, value = text.partition("=")
    try:
        return name, msgspec.json.decode(value)
    except msgspec.DecodeError:
        return name, value


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(map(whole(), text.split(",")))
