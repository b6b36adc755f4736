"""Verb ``ppaas robot urdf``: uploads, downloads and deletes the URDF of a robot, and shows its description."""

import argparse
import sys
from pathlib import Path
from typing import Any

from robots.cli.output import print_warnings, show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

DESCRIPTION = (
    "base_frame", "circumscribed_radius", "inscribed_radius", "height", "max_vel_x", "max_vel_theta", "sensors",
)  # fmt: skip


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    verbs = parser.add_subparsers(dest="urdf_verb", required=True, metavar="VERB")
    put = verbs.add_parser("put", help="upload the URDF of a robot, and show the description derived from it")
    get = verbs.add_parser("get", help="print the URDF of a robot")
    delete = verbs.add_parser("delete", help="delete the URDF of a robot")
    for verb in (put, get, delete):
        verb.add_argument("id", help="id of the robot")
        add_session_arguments(verb)
    put.add_argument("file", type=Path, help="URDF file, or a xacro file, which is expanded")
    add_mesh_argument(put)


def add_mesh_argument(parser: argparse.ArgumentParser | argparse._ArgumentGroup) -> None:
    """Add the argument for folders of meshes."""
    parser.add_argument(
        "--mesh-folder",
        type=Path,
        action="append",
        default=[],
        metavar="FOLDER",
        help="folder of packages or meshes of the URDF (also: those around it, and those of ROS)",
    )
    parser.add_argument(
        "--xacro-arg",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="argument of a xacro file, for its $(arg NAME)",
    )


async def run(arguments: argparse.Namespace) -> None:
    """Execute the verb."""
    await _VERBS[arguments.urdf_verb](arguments)


async def _put(arguments: argparse.Namespace) -> None:
    description = await logged_in(arguments).put_urdf(arguments.id, read_urdf(arguments.file, arguments))
    show_description(description, as_json=arguments.json)


async def _get(arguments: argparse.Namespace) -> None:
    urdf = await logged_in(arguments).fetch(path_of("robots", arguments.id, "urdf"))
    sys.stdout.buffer.write(urdf)


async def _delete(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(path_of("robots", arguments.id, "urdf"))


def read_urdf(path: Path, arguments: argparse.Namespace) -> bytes:
    """Return the bytes of a URDF file, with the extents of its meshes; xacro is expanded.

    Raises
    ------
    InvalidInput
        The file or a mesh cannot be read, or the file is xacro that cannot be expanded.
    """
    from robots.client.urdf_files import read_urdf_file  # noqa: PLC0415 - ``ppaas --help`` loads this module

    given = dict(each.partition("=")[::2] for each in arguments.xacro_arg)
    return read_urdf_file(path, arguments.mesh_folder, given)


def show_description(description: dict[str, Any], *, as_json: bool) -> None:
    """Print the description derived from a URDF, and its warnings."""
    if as_json:
        show(description, DESCRIPTION, as_json=True)
        return
    sensors = [f"{sensor['link']} ({sensor['kind']})" for sensor in description["sensors"]]
    show(description | {"sensors": sensors}, DESCRIPTION, as_json=False)
    print_warnings(description)


_VERBS = {"put": _put, "get": _get, "delete": _delete}
