"""Options of ``ppaas robot put`` that read parameter files of other programs, and the robot file that they make."""

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput, InvalidParameter

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation
    from robots.client.robot_file import RobotFile

_OPTIONS = {
    "nav2": ("--nav2", "parameters of Nav2, Humble to Rolling"),
    "slam_toolbox": ("--slam-toolbox", "parameters of slam_toolbox: the robot makes a map, or is localized on one"),
    "gmapping": ("--gmapping", "parameters of gmapping: the robot makes a map"),
    "cartographer": ("--cartographer", "options of cartographer in Lua: the robot makes a map, or is localized on one"),
    "ros1": ("--ros1", "parameters of ROS 1: move_base, costmaps, planners, recovery behaviours, amcl"),
    "amcl": ("--amcl", "parameters of amcl, of ROS 1 or of Nav2"),
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    group = parser.add_argument_group(
        "import", "Parameter files of other programs. FILE.json wins over them, and a later one over an earlier one."
    )
    group.add_argument("--map", metavar="MAP", help="map of the robot, or new:MAP for one that it makes")
    for name, (option, words) in _OPTIONS.items():
        if name == "ros1":  # its files belong together
            group.add_argument(option, type=Path, nargs="+", action="extend", default=[], metavar="FILE", help=words)
        else:
            group.add_argument(option, dest=name, type=Path, action="append", default=[], metavar="FILE", help=words)
    group.add_argument("--bt-xml", type=Path, metavar="FILE", help="with --nav2: behaviour tree that the robot has")
    group.add_argument("--namespace", default="", metavar="NAME", help="with --nav2: robot of a file for several")
    group.add_argument(
        "--dry-run",
        action="store_true",
        help="print the robot file and what became of each parameter, and send nothing",
    )


def robot_file(arguments: argparse.Namespace) -> "RobotFile":
    """Return the robot file of the arguments, and print the reports of what was imported.

    Raises
    ------
    InvalidInput
        A file cannot be read, or an option of Nav2 is given without its parameters.
    InvalidParameter
        No map is named, a file is no parameter file, or the robot file is invalid; the text says why.
    """
    from robots.client.robot_file import load_robot_file, parse_robot_file  # noqa: PLC0415 - for ``ppaas --help``

    if not arguments.nav2 and (arguments.bt_xml is not None or arguments.namespace):
        raise InvalidInput("--bt-xml and --namespace go with --nav2 FILE, and have no effect without it")
    if not _given(arguments) and arguments.map is None:
        if arguments.file is None:
            raise InvalidParameter("name a robot file, or files to import: see ppaas robot put --help")
        return load_robot_file(arguments.file)
    return parse_robot_file(json.dumps(_imported(arguments)))


def _given(arguments: argparse.Namespace) -> bool:
    return any(getattr(arguments, name) for name in _OPTIONS)


def _imported(arguments: argparse.Namespace) -> dict[str, Any]:
    from ppaas.imports.parameters.clone_check import refusal  # noqa: PLC0415 - needs the extra imports
    from ppaas.imports.parameters.draft import robot_file  # noqa: PLC0415 - as above
    from robots.cli.import_report import print_report  # noqa: PLC0415 - as above

    own = {} if arguments.file is None else _own(arguments.file)
    if arguments.map is not None:
        own["map"] = arguments.map
    translations = list(_translations(arguments))
    if "map" not in own and not any("map" in draft for draft, _ in translations):
        raise InvalidParameter(
            "name the published map of the robot by --map MAP, or a map that it makes by --map new:MAP"
        )
    merged = robot_file(translations, own, refusal)
    for _, report in translations:
        print_report(report, as_json=arguments.json)
    return merged


def _translations(arguments: argparse.Namespace) -> "Iterator[Translation]":
    """Return the translations of all files, in the order of the options of `_OPTIONS`."""
    from ppaas.imports.parameters.nav2.importer import import_nav2  # noqa: PLC0415 - as above
    from ppaas.imports.parameters.ros1.amcl import import_amcl  # noqa: PLC0415 - needs the extra imports
    from ppaas.imports.parameters.ros1.importing import import_ros1_files  # noqa: PLC0415 - as above
    from ppaas.imports.parameters.slam.cartographer import import_cartographer  # noqa: PLC0415 - as above
    from ppaas.imports.parameters.slam.gmapping import import_gmapping  # noqa: PLC0415 - as above
    from ppaas.imports.parameters.slam.slam_toolbox import import_slam_toolbox  # noqa: PLC0415 - as above

    tree = None if arguments.bt_xml is None else _read(arguments.bt_xml)
    for path in arguments.nav2:
        yield import_nav2(_read(path), path.name, tree=tree, namespace=arguments.namespace)
    new_map = arguments.id.rpartition(":")[2]
    makers = {"slam_toolbox": import_slam_toolbox, "gmapping": import_gmapping, "cartographer": import_cartographer}
    for name, translate in makers.items():
        for path in getattr(arguments, name):
            yield translate(_read(path), path.name, new_map)
    yield from import_ros1_files([(_read(path), path.name) for path in arguments.ros1], new_map)
    for path in arguments.amcl:
        yield import_amcl(_read(path), path.name)


def _own(path: Path) -> dict[str, Any]:
    """Return a robot file as its user wrote it, without defaults."""
    try:
        file = json.loads(_read(path))
    except (ValueError, RecursionError) as error:
        raise InvalidInput(f"the robot file is not JSON: {error}") from error
    if not isinstance(file, dict):
        raise InvalidParameter(f"the robot file must be an object, not {type(file).__name__}")
    return file


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read {path}: {error}") from error


def show_file(file: "RobotFile") -> None:
    """Print a robot file as JSON on standard output."""
    sys.stdout.write(json.dumps(json.loads(file.encode()), indent=2) + "\n")
