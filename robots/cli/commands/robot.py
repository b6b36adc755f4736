"""Command ``ppaas robot``: robots with their files, URDFs, nodes and goals."""

import argparse
import sys
from pathlib import Path
from typing import Any

from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.resource import Resource, merge_patch
from robots.cli.session import add_session_arguments, logged_in
from robots.cli.verbs import (
    robot_docks,
    robot_drive,
    robot_goals,
    robot_import,
    robot_list,
    robot_map,
    robot_recordings,
    robot_shares,
    robot_urdf,
)
from robots.client.cloud_url import path_of

NAME = "robot"
HELP = "put, list, show, change, share, record and delete robots; send them to a pose"

ROBOTS = Resource(
    "robots",
    ("id", "map", "model", "initial_pose", "cores", "base_global_planner", "base_local_planner", "stopped"),
    "no robots; register one: ppaas robot put ID FILE.json",
)
CHANGE_HELP = "cores=0.5, map=office, initial_pose=[1,2,0], parameters.amcl.max_particles=800; null for the default"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    put = verbs.add_parser("put", help="register a robot, or replace its robot file")
    listing = verbs.add_parser("list", help="list your robots")
    one = verbs.add_parser("show", help="show one robot")
    change = verbs.add_parser("change", help="change fields of a robot file")
    delete = verbs.add_parser("delete", help="delete a robot")
    configure_nodes(verbs.add_parser("nodes", help="show where the nodes of a robot run, or move one"))
    robot_map.configure(verbs.add_parser("map", help="show or publish the map that a robot makes"))
    robot_goals.configure_go(verbs.add_parser("go", help="send a connected robot to a pose"))
    robot_goals.configure_state(verbs.add_parser("state", help="show the pose and the goals of a robot"))
    robot_goals.configure_state(verbs.add_parser("stop", help="cancel all goals of a robot; 'ppaas stop' holds it"))
    robot_docks.configure_dock(verbs.add_parser("dock", help="dock a robot until its battery is charged"))
    robot_docks.configure_undock(verbs.add_parser("undock", help="drive a robot out of its dock"))
    robot_goals.configure_move(verbs.add_parser("move", help="report that a robot is on another map now"))
    robot_drive.configure(verbs.add_parser("drive", help="drive a robot by hand, by the keys of this terminal"))
    robot_recordings.configure_record(verbs.add_parser("record", help="record a robot, or fetch its last minutes"))
    robot_recordings.configure_recordings(verbs.add_parser("recordings", help="list, fetch and delete recordings"))
    robot_urdf.configure(verbs.add_parser("urdf", help="upload, download and delete the URDF of a robot"))
    robot_shares.configure_share(verbs.add_parser("share", help="share a robot with a user or a group"))
    robot_shares.configure_unshare(verbs.add_parser("unshare", help="share a robot no more"))
    for verb in (put, one, change, delete):
        verb.add_argument("id", help="id of the robot; OWNER:ID for one of another user")
    robot_list.configure(listing)
    put.add_argument("file", type=Path, nargs="?", help="the robot file")
    put.add_argument("--urdf", type=Path, metavar="FILE", help="upload this URDF too")
    put.add_argument("--radius", type=float, metavar="M", help="radius of the robot [m], instead of that of the URDF")
    robot_urdf.add_mesh_argument(put)
    robot_import.configure(put)
    change.add_argument("changes", nargs="+", metavar="NAME=VALUE", help=CHANGE_HELP)
    for verb in (put, one, change, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _put(arguments: argparse.Namespace) -> None:
    urdf = None if arguments.urdf is None else robot_urdf.read_urdf(arguments.urdf, arguments)
    file = robot_import.robot_file(arguments).with_radius(arguments.radius)
    if arguments.dry_run:
        robot_import.show_file(file)
        return
    client = logged_in(arguments)
    await client.put_robot(arguments.id, file)
    if file.unused is not None:
        when = "on a published map" if file.unused == "grid_slam" else "while the robot makes a map"
        sys.stderr.write(f"note: the parameters of {file.unused} are not used {when}\n")
    if urdf is not None:
        await client.put_urdf(arguments.id, urdf)
    await _show(arguments)


async def _show(arguments: argparse.Namespace) -> None:
    one = await logged_in(arguments).get(path_of("robots", arguments.id))
    show(one, ROBOTS.columns, as_json=arguments.json)
    if one.get("urdf") is not None and not arguments.json:
        robot_urdf.show_description(one["urdf"], as_json=False)


async def _change(arguments: argparse.Namespace) -> None:
    change = merge_patch(arguments.changes)
    changed = await logged_in(arguments).patch(path_of("robots", arguments.id), change)
    show(changed, ROBOTS.columns, as_json=arguments.json)


COLUMNS = ("node", "home", "wanted", "score", "why")


def configure_nodes(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.add_argument("id", help="id of a connected robot")
    parser.add_argument("--run", dest="node", metavar="NODE", help="move this node to the home where it performs best")
    parser.add_argument("--home", choices=("cloud", "robot"), help="with --run: the home to move it to")
    add_session_arguments(parser)


async def run_nodes(arguments: argparse.Namespace) -> None:
    """Execute the verb."""
    client = logged_in(arguments)
    nodes = path_of("robots", arguments.id, "nodes")
    if arguments.node is None:
        found = await client.items(nodes)
    else:
        path = path_of("robots", arguments.id, "nodes", arguments.node)
        found = [await client.post(path, {"home": arguments.home})]
    show(found if arguments.json else list(map(_row, found)), COLUMNS, as_json=arguments.json)


def _row(node: dict[str, Any]) -> dict[str, Any]:
    return node | {"score": round(node["score"], 2), "why": "; ".join(node["reasons"])}


_VERBS = {
    "put": _put,
    "list": robot_list.run,
    "show": _show,
    "change": _change,
    "delete": ROBOTS.delete,
    "nodes": run_nodes,
    "dock": robot_docks.dock,
    "undock": robot_docks.undock,
    "drive": robot_drive.run,
    "map": robot_map.run,
    "move": robot_goals.move,
    "go": robot_goals.go,
    "state": robot_goals.state,
    "stop": robot_goals.stop,
    "record": robot_recordings.record,
    "recordings": robot_recordings.recordings,
    "share": robot_shares.share,
    "unshare": robot_shares.unshare,
    "urdf": robot_urdf.run,
}
