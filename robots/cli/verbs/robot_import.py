"""Part of the verb ``ppaas robot put``: parameter files of other programs, which become a robot file."""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput, InvalidParameter
from robots.cli.output import print_line

if TYPE_CHECKING:
    from ppaas.imports.parameters.draft import Translation
    from robots.client.robot_file import RobotFile


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the files that are translated."""
    parser.add_argument("--map", metavar="MAP", help="id of the robot's map, instead of the one in the robot file")
    parser.add_argument(
        "--nav2", type=Path, action="append", default=[], metavar="FILE",
        help="translate this parameter file of Nav2; of several, the later one wins, and the robot file over all",
    )  # fmt: skip
    parser.add_argument("--bt-xml", type=Path, metavar="FILE", help="with --nav2: behaviour tree that the robot has")
    parser.add_argument("--namespace", default="", metavar="NAME", help="with --nav2: robot of a file for several")
    parser.add_argument(
        "--dry-run", action="store_true", help="print the report and the robot file; send nothing, and need no cloud"
    )


def is_wanted(arguments: argparse.Namespace) -> bool:
    """Return whether files are to be translated, or the robot file is only to be printed."""
    return bool(arguments.nav2 or arguments.map or arguments.dry_run)


def translated_file(arguments: argparse.Namespace) -> "RobotFile | None":
    """Translate all files, print their reports, and return the robot file; None after ``--dry-run``.

    Raises
    ------
    InvalidInput
        A file cannot be read.
    InvalidParameter
        A file is no parameter file, or the robot file is invalid; the text says why.
    """
    from ppaas.imports.parameters.draft import robot_file  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from robots.cli.import_report import print_report  # noqa: PLC0415
    from robots.client.robot_file import parse_robot_file  # noqa: PLC0415

    own = _own_file(arguments)
    translations = _translations(arguments)
    file = dict(own)
    if translations:
        from ppaas.imports.parameters.clone_check import refusal  # noqa: PLC0415 - loads the kernels

        file = robot_file(translations, own, refusal)
    for _, report in translations:
        print_report(report, as_json=arguments.json)
    if arguments.dry_run:
        print_line(json.dumps(file, indent=2))
        return None
    if "map" not in file:
        raise InvalidParameter("a robot is on a map: name it with --map MAP, or in the robot file")
    return parse_robot_file(json.dumps(file))


def _own_file(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the user's own robot file as it is, without defaults, on the map that is named."""
    own: dict[str, Any] = {}
    if arguments.file is not None:
        from robots.client.robot_file import parse_robot_file  # noqa: PLC0415 - as above

        content = _read(arguments.file, "robot file")
        try:
            decoded = json.loads(content)
        except (ValueError, RecursionError) as error:
            raise InvalidInput(f"the robot file is not JSON: {error}") from error
        if not isinstance(decoded, Mapping):
            raise InvalidParameter("the robot file must be an object")
        own = dict(decoded)
        parse_robot_file(json.dumps({"map": "map", **own}))  # refuses unknown fields and invalid values
    if arguments.map is not None:
        own["map"] = arguments.map
    return own


def _translations(arguments: argparse.Namespace) -> "list[Translation]":
    if not arguments.nav2:
        return []
    from ppaas.imports.parameters.nav2.importer import import_nav2  # noqa: PLC0415 - needs the extra plan

    tree = None if arguments.bt_xml is None else _read(arguments.bt_xml, "behaviour tree")
    return [
        import_nav2(_read(path, "parameter file"), path.name, tree=tree, namespace=arguments.namespace)
        for path in arguments.nav2
    ]


def _read(path: Path, what: str) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the {what}: {error}") from error
