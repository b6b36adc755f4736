"""Command ``ppaas export``: writes a robot as a set-up of another program, with a report of what it cannot express."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput, NotFound
from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.output_files import write_file
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from ppaas.exports.ros2.robot import MapToExport
    from robots.client.rest import RestClient

NAME = "export"
HELP = "write a robot as a set-up of Nav2 and slam_toolbox, which needs no cloud"

RELEASES = ("humble", "jazzy", "kilted", "rolling")
"""Releases of ROS 2; as in `ppaas.exports.ros2.releases`, which ``ppaas --help`` must not load."""

COLUMNS = ("folder", "release", "files")

FIELDS = (
    "map", "model", "initial_pose", "cores", "base_global_planner", "base_local_planner", "parameters", "description",
    "properties", "labels",
)  # fmt: skip
"""Fields of a robot in REST that are its robot file."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    ros2 = verbs.add_parser(
        "ros2",
        help="write parameters, map, masks, behaviour tree, URDF and a launch file for Nav2 and slam_toolbox",
        description="The report of what became of each parameter and zone is printed to standard error.",
    )
    ros2.add_argument("id", metavar="ROBOT", help="id of the robot; OWNER:ID for one of another user")
    ros2.add_argument("--out", type=Path, metavar="DIR", help="folder for the files (ROBOT-ros2)")
    ros2.add_argument("--release", choices=RELEASES, default="jazzy", help="release of ROS 2 (%(default)s)")
    ros2.add_argument("--dry-run", action="store_true", help="only print the report; write nothing")
    add_session_arguments(ros2)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_ros2(arguments))
    return 0


async def _ros2(arguments: argparse.Namespace) -> None:
    from ppaas.exports.ros2.releases import Release  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.exports.ros2.robot import robot_to_export  # noqa: PLC0415
    from ppaas.exports.ros2.setup import export_ros2  # noqa: PLC0415
    from robots.cli.import_report import print_report  # noqa: PLC0415

    client = logged_in(arguments)
    found = await client.get(path_of("robots", arguments.id))
    file = {name: found[name] for name in FIELDS if found.get(name) is not None}
    urdf = None if found.get("urdf") is None else await client.fetch(path_of("robots", arguments.id, "urdf"))
    robot = robot_to_export(found["id"], file, await _map(client, file), urdf)
    setup = export_ros2(robot, Release(arguments.release))
    print_report(setup.report, as_json=arguments.json)
    if arguments.dry_run:
        return
    folder = arguments.out or Path(f"{found['id']}-ros2")
    _write(folder, setup.files)
    answer = {"folder": str(folder), "release": arguments.release, "files": sorted(setup.files)}
    show(answer, COLUMNS, as_json=arguments.json)


async def _map(client: "RestClient", file: dict[str, Any]) -> "MapToExport | None":
    """Return the map of a robot with its zones, and the masks that its costmap filters name."""
    from ppaas.exports.ros2.robot import MapToExport  # noqa: PLC0415
    from ppaas.maps.new_map import new_map_id  # noqa: PLC0415
    from ppaas.nodes.map_server.costmap_filters import filter_masks  # noqa: PLC0415
    from ppaas.zones.reading import zones_of  # noqa: PLC0415
    from ppaas.zones.zone import NO_ZONES  # noqa: PLC0415
    from robots.cli.verbs.map_zones import geojson_of  # noqa: PLC0415

    if new_map_id(file["map"]) is not None:
        return None
    parts = (await client.get(path_of("maps", file["map"])))["parts"]
    zones = zones_of(await geojson_of(client, path_of("maps", file["map"], "zones"))) if "zones" in parts else NO_ZONES
    masks = {name: await _grid(client, mask) for name, mask in filter_masks(file.get("parameters", {})).items()}
    return MapToExport(file["map"], await _grid(client, file["map"]), zones, masks, "octomap" in parts)


async def _grid(client: "RestClient", map_id: str) -> Any:
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415

    try:
        yaml, image = [await client.fetch(path_of("maps", map_id, part)) for part in ("yaml", "image")]
    except NotFound as error:
        raise InvalidInput(f"map {map_id!r} has no image, which Nav2 needs: publish it with one") from error
    return load_map(yaml, image)


def _write(folder: Path, files: dict[str, bytes]) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"cannot write to {folder}: {error}") from error
    for name, content in files.items():
        write_file(folder / name, content)
