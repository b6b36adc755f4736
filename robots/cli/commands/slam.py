"""Command ``ppaas slam``: makes a map of a recorded drive, and scores trajectories."""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.output import printable, show
from robots.cli.output_files import check_folder, write_file
from robots.cli.resource import merge_patch

if TYPE_CHECKING:
    from ppaas.mapping.parameters import SlamParameters
    from ppaas.mapping.pipeline.offline import LogMap
    from ppaas.mapping.scan_log import ScanLog
    from ppaas.mapping.trajectories import PlanarTrajectory
    from robots.recordings.recording import RecordedFrames

NAME = "slam"
HELP = "make a map of a log or a bag with laser scans and odometry, or score a trajectory"

FORMATS = ("carmen", "flirt", "bag")
"""Formats of recordings; as in `robots.recordings.scan_logs`, which ``ppaas --help`` must not load."""

GRAPHS, POSEGRAPH = (".g2o", ".graph", ".toro"), ".posegraph"
"""Endings of pose graphs without scans, of g2o and of TORO, and of those with scans."""

OCTOMAPS = (".bt", ".ot")
"""Endings of octomaps: binary, and with all probabilities."""

TRAJECTORIES = ("planar", "tum", "kitti")
"""Formats of trajectories; as in `ppaas.mapping.trajectories`, which ``ppaas --help`` must not load."""

METHODS = ("none", "scaling", "graduated")
"""Methods of `ppaas.mapping.graph.solver.Robust`, which ``ppaas --help`` must not load."""

COLUMNS = ("scans", "key_frames", "closures", "distrusted_edges", "total_seconds")
FLOORS = ("floor", "map", "elevation", "scans", "key_frames", "closures")
SOLVED = ("nodes", "edges", "fixed", "chi2", "distrusted_edges", "method", "iterations", "seconds")
SCORES = ("mean_m", "std_m", "max_m", "rmse_m", "mean_deg", "std_deg", "max_deg", "relations", "poses", "unmatched")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "Poses are those of the robot, in the frame of the odometry at the start. Without LOG, --score reads the "
        "trajectory from the file of --trajectory."
    )
    parser.add_argument(
        "log",
        type=Path,
        nargs="?",
        metavar="LOG",
        help="log of CARMEN or bag of ROS, also compressed, a folder of a bag, or a pose graph to solve (.g2o)",
    )
    parser.add_argument("--format", choices=FORMATS, help="format of LOG (that of its name and lines)")
    parser.add_argument(
        "--parameter", action="append", metavar="NAME=VALUE", help="parameter of mapping, as max_laser_range=20"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    _configure_outputs(parser)
    _configure_floors(parser)
    _configure_inputs(parser)


def _configure_outputs(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--map", type=Path, metavar="OUT.yaml", help="write the map, with its image beside it")
    parser.add_argument(
        "--trajectory", type=Path, metavar="OUT.txt", help="write a line 'timestamp x y theta' for every scan"
    )
    parser.add_argument(
        "--trajectory-format",
        choices=TRAJECTORIES,
        help="format of --trajectory (by its ending .tum or .kitti, else planar: 'timestamp x y theta')",
    )
    parser.add_argument(
        "--posegraph",
        type=Path,
        metavar="OUT.posegraph",
        help="write the key frames with their pose graph",
    )
    parser.add_argument(
        "--graph", type=Path, metavar="OUT.g2o", help="write the pose graph of the key frames; TORO's as OUT.graph"
    )
    parser.add_argument(
        "--octomap",
        type=Path,
        metavar="OUT.bt",
        help="write a 3D map of depth images and clouds of a bag; or OUT.ot",
    )
    parser.add_argument(
        "--octomap-parameter", action="append", metavar="NAME=VALUE", help="parameter of it, as resolution=0.1"
    )
    parser.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the map and the trajectory")
    parser.add_argument(
        "--score",
        type=Path,
        metavar="RELATIONS",
        help="print errors: lines 't1 t2 x y z roll pitch yaw' are true, or a trajectory, also of TUM or KITTI",
    )


def _configure_floors(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--floors",
        type=Path,
        metavar="FOLDER",
        help="write a map of each floor of a drive over several floors, and their building; of a bag with a barometer, "
        "or an odometry with heights",
    )


def _configure_inputs(parser: argparse.ArgumentParser) -> None:
    graph = parser.add_argument_group("pose graphs")
    graph.add_argument(
        "--robust",
        choices=METHODS,
        help="weight of loop closures of a graph that contradict other edges: none trusts all, as g2o does (default: "
        "none if all agree, else what explains more of them)",
    )
    bag = parser.add_argument_group("bags of ROS", "default: what the transforms and the odometry of the bag say")
    bag.add_argument("--scan-topic", metavar="TOPIC", help="use the scans of this topic alone, as /scan_front")
    bag.add_argument("--height-topic", metavar="TOPIC", help="find the floors by this topic, as /barometer")
    bag.add_argument("--odom-frame", metavar="FRAME", help="frame of the odometry, as odom_combined")
    bag.add_argument("--base-frame", metavar="FRAME", help="frame of the robot, as robot1/base_footprint")


def run(arguments: argparse.Namespace) -> int:
    """Execute the command."""
    if arguments.log is None:
        _score_file(arguments)
        return 0
    _check_outputs(arguments)
    try:
        with event_loop.terminable():
            _make(arguments)
    except KeyboardInterrupt:
        sys.stderr.write("ppaas: interrupted before all files were written; those that are there are whole\n")
        raise
    return 0


def _make(arguments: argparse.Namespace) -> None:
    from robots.cli.verbs.slam_graph import is_graph  # noqa: PLC0415

    if arguments.format is None and is_graph(arguments.log):
        show(_solve(arguments), SOLVED, as_json=arguments.json)
    elif arguments.floors is not None:
        show(_map_floors(arguments), FLOORS, as_json=arguments.json)
    else:
        answer = _map(arguments)
        show(answer, (*COLUMNS, *_scores(answer)), as_json=arguments.json)


def _scores(answer: dict[str, Any]) -> tuple[str, ...]:
    return tuple(name for name in SCORES if name in answer)


def _score_file(arguments: argparse.Namespace) -> None:
    from ppaas.mapping.trajectories import parse_trajectory  # noqa: PLC0415 - ``ppaas --help`` loads this module

    if arguments.score is None or arguments.trajectory is None:
        raise InvalidInput("give a LOG to map, or --trajectory and --score to score a trajectory")
    outputs = (arguments.map, arguments.plot, arguments.graph, arguments.posegraph, arguments.octomap, arguments.floors)
    if any(path is not None for path in outputs):
        raise InvalidInput("--map, --plot, --graph, --posegraph, --octomap and --floors need a LOG")
    if arguments.trajectory_format is not None:
        raise InvalidInput("--trajectory-format is of a trajectory that is written: give a LOG")
    answer = _scored(arguments.score, parse_trajectory(_text(arguments.trajectory)))
    show(answer, _scores(answer), as_json=arguments.json)


def _check_outputs(arguments: argparse.Namespace) -> None:
    """Raise ``InvalidInput`` for files that could not be written, before the work of mapping."""
    if arguments.plot is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415

        check_picture(arguments.plot)
    if arguments.map is not None and arguments.map.suffix not in (".yaml", ".yml"):
        raise InvalidInput(f"a map is a YAML file; use {arguments.map.stem or 'map'}.yaml, not {str(arguments.map)!r}")
    if arguments.graph is not None and arguments.graph.suffix not in GRAPHS:
        stem = arguments.graph.stem or "graph"
        raise InvalidInput(f"a graph is a file of g2o or TORO; use {stem}.g2o or {stem}.graph")
    if arguments.trajectory is None and arguments.trajectory_format is not None:
        raise InvalidInput("--trajectory-format is of a trajectory: give --trajectory too")
    if arguments.posegraph is not None and arguments.posegraph.suffix != POSEGRAPH:
        raise InvalidInput(f"a pose graph with scans is a file {arguments.posegraph.stem or 'map'}{POSEGRAPH}")
    if arguments.octomap is not None and arguments.octomap.suffix not in OCTOMAPS:
        raise InvalidInput(f"an octomap is a file {arguments.octomap.stem or 'map'}.bt or .ot")
    files = ("map", "trajectory", "plot", "graph", "posegraph", "octomap")
    for path in (getattr(arguments, name) for name in files):
        if path is not None:
            check_folder(path)


def _read(arguments: argparse.Namespace) -> "tuple[ScanLog, SlamParameters, RecordedFrames]":
    from ppaas.mapping.parameters import SlamParameters  # noqa: PLC0415
    from ppaas.parameters import read_parameters  # noqa: PLC0415
    from robots.recordings.recording import RecordedFrames  # noqa: PLC0415
    from robots.recordings.scan_logs import read_scan_log  # noqa: PLC0415

    parameters = read_parameters(SlamParameters, "slam", merge_patch(arguments.parameter or []))
    frames = RecordedFrames(arguments.scan_topic, arguments.odom_frame, arguments.base_frame)
    return read_scan_log(arguments.log, arguments.format, frames, _note), parameters, frames


def _map_floors(arguments: argparse.Namespace) -> list[dict[str, Any]]:
    from robots.cli.buildings.slam_floors import check_floors, map_floors  # noqa: PLC0415

    outputs = ("map", "trajectory", "plot", "graph", "posegraph", "octomap", "score")
    given = [name for name in outputs if getattr(arguments, name) is not None]
    if given:
        raise InvalidInput(f"--{given[0]} is of one map: leave it out with --floors")
    check_floors(arguments.floors)
    log, parameters, _ = _read(arguments)
    return map_floors(
        arguments.log, log, arguments.floors, arguments.height_topic,
        mapped=lambda part, name: _mapped(part, parameters, name), resolution=parameters.resolution,
    )  # fmt: skip


def _map(arguments: argparse.Namespace) -> dict[str, Any]:
    from ppaas.mapping.trajectories import PlanarTrajectory  # noqa: PLC0415

    log, parameters, frames = _read(arguments)
    made = _mapped(log, parameters, arguments.log.name)
    _write(arguments, log, made, parameters.resolution)
    trajectory = PlanarTrajectory(log.stamps, made.poses)
    if arguments.octomap is not None:
        from robots.cli.verbs.slam_octomap import FULL, octomap_of  # noqa: PLC0415

        own = merge_patch(arguments.octomap_parameter or [])
        full = arguments.octomap.suffix == FULL
        write_file(arguments.octomap, octomap_of(arguments.log, trajectory, frames, own, _note, full=full))
    answer = made.summary()
    answer |= {"skipped": log.skipped, "total_seconds": round(sum(made.seconds.values()), 2)}
    if arguments.score is not None:
        answer |= _scored(arguments.score, trajectory)
    return answer


def _solve(arguments: argparse.Namespace) -> dict[str, Any]:
    """Solve a pose graph, write it, and return the numbers of its parts and its error."""
    from robots.cli.verbs.slam_graph import solve_file  # noqa: PLC0415

    others = (
        arguments.map, arguments.plot, arguments.trajectory, arguments.score, arguments.posegraph, arguments.octomap
    )  # fmt: skip
    if any(given is not None for given in others):
        raise InvalidInput(f"{arguments.log} is a pose graph, without scans: only --graph can be written")
    of_toro = arguments.graph is not None and arguments.graph.suffix != GRAPHS[0]
    solved = solve_file(arguments.log, arguments.robust, of_toro=of_toro)
    if arguments.graph is not None:
        write_file(arguments.graph, solved.content)
    for note in solved.notes:
        _note(note)
    return solved.answer


def _note(text: str) -> None:
    sys.stderr.write(f"note: {printable(text)}\n")


def _mapped(log: "ScanLog", parameters: "SlamParameters", name: str) -> "LogMap":
    """Map the log and show the progress, on a terminal."""
    from rich.console import Console  # noqa: PLC0415 - a robot's install lacks rich
    from rich.progress import Progress  # noqa: PLC0415

    from ppaas.mapping.pipeline.offline import map_log  # noqa: PLC0415

    console = Console(stderr=True)
    with Progress(console=console, transient=True, disable=not console.is_terminal) as progress:
        task = progress.add_task(f"map {name}", total=len(log))
        return map_log(log, parameters, done=lambda scans: progress.update(task, completed=scans))


def _write(arguments: argparse.Namespace, log: "ScanLog", made: "LogMap", resolution: float) -> None:
    if arguments.trajectory is not None:
        from ppaas.mapping.trajectories import TRAJECTORY_FORMATS, format_trajectory  # noqa: PLC0415

        named = arguments.trajectory_format or arguments.trajectory.suffix[1:].lower()
        form = next((form for form in TRAJECTORY_FORMATS if form == named), TRAJECTORY_FORMATS[0])
        write_file(arguments.trajectory, format_trajectory(log.stamps, made.poses, form).encode())
    if arguments.graph is not None:
        from ppaas.mapping.graph.g2o import format_graph  # noqa: PLC0415

        lines = format_graph(made.mapper.graph, of_toro=arguments.graph.suffix != GRAPHS[0])
        write_file(arguments.graph, "".join(lines).encode())
    if arguments.posegraph is not None:
        from ppaas.mapping.serialization.mapping import Mapping  # noqa: PLC0415
        from ppaas.mapping.serialization.mapping_file import pack_mapping  # noqa: PLC0415

        write_file(arguments.posegraph, b"".join(pack_mapping(Mapping(made.mapper.key_frames, made.mapper.graph))))
    if arguments.map is None and arguments.plot is None:
        return
    from ppaas.maps.formats.map_files import save_map  # noqa: PLC0415
    from robots.pictures.map_pictures import write_trajectory  # noqa: PLC0415

    grid = made.grid(resolution)
    if arguments.map is not None:
        image = arguments.map.with_suffix(".pgm")
        record, pixels = save_map(grid, image.name)
        write_file(image, pixels)
        write_file(arguments.map, record)
    if arguments.plot is not None:
        write_trajectory(arguments.plot, grid, made.poses)


def _scored(path: Path, found: "PlanarTrajectory") -> dict[str, Any]:
    from ppaas.mapping.relations import parse_relations, score, score_by_truth  # noqa: PLC0415
    from ppaas.mapping.trajectories import is_trajectory, parse_trajectory  # noqa: PLC0415

    text = _text(path)
    if is_trajectory(text):
        return score_by_truth(parse_trajectory(text), found).summary()
    if found.stamps is None:
        raise InvalidInput("a trajectory of KITTI has no stamps, by which relations are found: give one with stamps")
    return score(parse_relations(text), found.stamps, found.poses).summary()


def _text(path: Path) -> str:
    try:
        return path.read_text("utf-8-sig", errors="replace")
    except OSError as error:
        raise InvalidInput(f"cannot read the file: {error}") from error
