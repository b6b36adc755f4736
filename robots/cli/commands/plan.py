"""Command ``ppaas plan``: plans a path on a map file or on a map of the cloud, and manages stored paths."""

import argparse
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.resource import merge_patch
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.cli.verbs import plan_database
from robots.cli.verbs.robot_urdf import add_mesh_argument, read_urdf
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from ppaas.costmap.costmap import Costmap
    from robots.client.rest import RestClient
    from robots.plans.offline import PlannedRobot

NAME = "plan"
HELP = "plan a path on a map file or in the cloud; list, show and delete stored paths"
DEFAULT_VERB = "create"

OFFLINE = ("planner", "length", "cost", "expanded", "seconds")
COLUMNS = ("plan_id", *OFFLINE, "container", "pid")
KEPT = ("plan_id", "map", "planner", "start", "goal", "length", "cost", "seconds", "user", "robot", "created")

OCTOMAPS = (".bt", ".ot")
IMAGES = (".pgm", ".pnm", ".png", ".ppm", ".pbm", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff")
"""``ENDINGS`` of images, which ``ppaas --help`` must not load."""

FILES = (".yaml", ".yml", ".map", *IMAGES, *OCTOMAPS)

PLANNER = "dijkstra"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "The verb may be left out: 'ppaas plan MAP.yaml --start 2 2 --goal 10 8' creates a path, without a cloud. "
        "A MAP that is not a file is the id of a map in the cloud. 'ppaas plan create --help' lists the options."
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    create = verbs.add_parser("create", help="plan a path (the default verb)")
    _configure_create(create)
    listing = verbs.add_parser("list", help="list the stored paths of a map, newest first")
    listing.add_argument("map", help="id of the map")
    add_limit_argument(listing)
    one = verbs.add_parser("show", help="show a stored path")
    delete = verbs.add_parser("delete", help="delete a stored path")
    for verb in (one, delete):
        verb.add_argument("id")
    matrix = verbs.add_parser("matrix", help="compute the cost from each start to each goal on a map file")
    matrix.add_argument("map", help="YAML file of a map or its image, or map of MovingAI (.map)")
    matrix.add_argument("ends", type=Path, help='JSON file: {"starts": [[x, y], ...], "goals": [[x, y], ...]} [m]')
    _add_robot_arguments(matrix)
    for verb in (create, one):
        verb.add_argument("--plot", type=Path, metavar="OUT.png", help="draw the path on its map")
    matrix.add_argument("--json", action="store_true", help="print JSON")
    for verb in (create, listing, one, delete):
        add_session_arguments(verb)
    plan_database.configure(verbs)


def _configure_create(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "map",
        help="YAML file of a map or its image, map of MovingAI (.map), octomap (.bt, .ot), or id of a map in the cloud",
    )
    for end in ("start", "goal"):
        help_ = "x y [yaw] in m and rad; in an octomap x y z [yaw]"
        parser.add_argument(f"--{end}", nargs="+", type=float, required=True, metavar="N", help=help_)
    parser.add_argument("--planner", help=f"name of the planner ({PLANNER}; in an octomap astar3d)")
    parser.add_argument("--tolerance", type=float, default=0.0, help="greatest distance from a blocked goal [m] (0)")
    _add_robot_arguments(parser)
    space = parser.add_argument_group("with an octomap", "default: a Turtlebot2")
    space.add_argument("--height", type=float, metavar="M", help="height of the robot [m]")
    space.add_argument("--step", type=float, metavar="M", help="highest step that the robot climbs [m] (one voxel)")
    space.add_argument("--fly", action="store_true", help="the robot flies")
    space.add_argument(
        "--depth", type=int, help="depth of the octree, up to 16; each level less doubles the voxel size (16)"
    )


def _add_robot_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--parameter",
        action="append",
        metavar="NAME=VALUE",
        help="parameter of the planner or the costmap, as allow_unknown=false or inflation_radius=0.3",
    )
    robot = parser.add_argument_group("with a map file", "default: a Turtlebot2, as in the cloud")
    robot.add_argument("--radius", type=float, metavar="M", help="radius of the robot [m], instead of that of a URDF")
    size = robot.add_mutually_exclusive_group()
    size.add_argument("--model", help="model of the robot (turtlebot2)")
    size.add_argument(
        "--urdf", type=Path, metavar="FILE", help="URDF of the robot: footprint, and height in an octomap"
    )
    add_mesh_argument(robot)
    robot.add_argument(
        "--rules",
        choices=("map_server", "nav2"),
        help="rules for free and occupied pixels (those of the file, or map_server)",
    )


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    if getattr(arguments, "plot", None) is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - here and below: ``ppaas --help`` loads this module

        check_picture(arguments.plot)
    if arguments.verb == "create" and _is_file(arguments.map):
        _plan_offline(arguments)
    elif arguments.verb == "matrix":
        _matrix(arguments)
    else:
        event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


def _is_file(name: str) -> bool:
    path = Path(name)
    return path.is_file() or path.suffix.lower() in FILES


def _robot(arguments: argparse.Namespace) -> "PlannedRobot":
    from robots.plans import offline  # noqa: PLC0415

    urdf = None if arguments.urdf is None else read_urdf(arguments.urdf, arguments)
    parameters = merge_patch(arguments.parameter or [])
    return offline.PlannedRobot(arguments.model or offline.MODEL, arguments.radius, urdf, parameters)


def _costmap(arguments: argparse.Namespace, robot: "PlannedRobot") -> "Costmap":
    from ppaas.maps.formats.map_yaml import Rules  # noqa: PLC0415
    from robots.plans import offline  # noqa: PLC0415

    rules = None if arguments.rules is None else Rules(arguments.rules)
    return offline.costmap_for(Path(arguments.map), robot, rules)


def _matrix(arguments: argparse.Namespace) -> None:
    from robots.plans import matrix  # noqa: PLC0415

    robot = _robot(arguments)
    unknown, ends = robot.allows_unknown(), matrix.read_ends(arguments.ends)
    answer = matrix.answer_of(_costmap(arguments, robot), ends, allow_unknown=unknown)
    rows, columns = matrix.table_of(answer)
    show(answer if arguments.json else rows, columns, as_json=arguments.json, if_none="no starts")


def _plan_offline(arguments: argparse.Namespace) -> None:
    from ppaas.geometry import Pose2D  # noqa: PLC0415
    from robots.plans import offline  # noqa: PLC0415

    path, robot = Path(arguments.map), _robot(arguments)
    if path.suffix.lower() in OCTOMAPS:
        _plan_in_space(arguments, path, robot)
        return
    _refuse_octomap_options(arguments)
    start, goal = (Pose2D(*pose) for pose in _ends(arguments))
    costmap = _costmap(arguments, robot)
    planner = arguments.planner or PLANNER
    answer = offline.answer_of(offline.plan(costmap, start, goal, planner, arguments.tolerance, robot=robot))
    if arguments.plot is not None:
        _draw(arguments.plot, costmap, answer, robot.radius_of(), path.name)
    show(answer, OFFLINE, as_json=arguments.json)


def _plan_in_space(arguments: argparse.Namespace, path: Path, robot: "PlannedRobot") -> None:
    from ppaas.planners.volume import Pose3D  # noqa: PLC0415
    from robots.plans import offline, space  # noqa: PLC0415

    if (arguments.plot, arguments.rules, arguments.parameter) != (None, None, None):
        raise InvalidInput("--plot, --rules and --parameter need a 2D map; the map is an octomap")
    start, goal = (Pose3D(*pose) for pose in _ends(arguments, "x y z"))
    body_2d = robot.body()
    height = (body_2d.height or space.HEIGHT) if arguments.height is None else arguments.height
    body = space.SpaceBody(body_2d.robot_radius, height, arguments.step, arguments.fly)
    costmap = space.costmap_of_file(path, body, 16 if arguments.depth is None else arguments.depth)
    result = space.plan(costmap, start, goal, arguments.planner or space.PLANNER, arguments.tolerance)
    show(offline.answer_of(result), OFFLINE, as_json=arguments.json)


def _refuse_octomap_options(arguments: argparse.Namespace) -> None:
    if (arguments.height, arguments.step, arguments.fly, arguments.depth) != (None, None, False, None):
        raise InvalidInput(f"--height, --step, --fly and --depth need an octomap; {arguments.map!r} is not one")


async def _create(arguments: argparse.Namespace) -> None:
    start, goal = _ends(arguments)
    if (arguments.radius, arguments.model, arguments.urdf, arguments.rules) != (None, None, None, None):
        raise InvalidInput(f"--radius, --model, --urdf and --rules need a map file; {arguments.map!r} is not a file")
    _refuse_octomap_options(arguments)
    client = logged_in(arguments)
    options = {"planner": arguments.planner or PLANNER, "tolerance": arguments.tolerance}
    parameters = merge_patch(arguments.parameter or [])
    answer = await client.plan(arguments.map, start, goal, parameters=parameters, **options)
    if arguments.plot is not None:
        await _plot_kept(client, answer, arguments.plot)
    show(answer, COLUMNS, as_json=arguments.json)


def _ends(arguments: argparse.Namespace, axes: str = "x y") -> tuple[list[float], list[float]]:
    for end in ("start", "goal"):
        numbers = getattr(arguments, end)
        if len(numbers) - len(axes.split()) not in (0, 1):
            raise InvalidInput(f"--{end} must be {axes} [yaw] in metres and radians, not {len(numbers)} numbers")
        if not all(map(math.isfinite, numbers)):
            raise InvalidInput(f"--{end} must be finite numbers, not {' '.join(map(str, numbers))}")
    return arguments.start, arguments.goal


async def _list(arguments: argparse.Namespace) -> None:
    kept = await logged_in(arguments).items(path_of("maps", arguments.map, "plans"), arguments.limit)
    show(
        kept,
        KEPT,
        as_json=arguments.json,
        if_none="no stored paths on this map; plan one: ppaas plan MAP --start X Y --goal X Y",
    )


async def _show(arguments: argparse.Namespace) -> None:
    client = logged_in(arguments)
    kept = await client.get(_path(arguments.id))
    if arguments.plot is not None:
        await _plot_kept(client, kept, arguments.plot)
    show(kept, KEPT, as_json=arguments.json)


async def _delete(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(_path(arguments.id))


def _path(plan_id: str) -> str:
    return path_of("plans", plan_id)


async def _plot_kept(client: "RestClient", kept: Mapping[str, Any], picture: Path) -> None:
    """Draw a stored path on the map version that it was planned on."""
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415
    from robots.plans import offline  # noqa: PLC0415

    files = [path_of("maps", kept["map"], "versions", kept["version"], part) for part in ("yaml", "image")]
    record, image = [await client.fetch(file) for file in files]
    robot = offline.PlannedRobot()
    _draw(picture, offline.inflated(load_map(record, image), robot), kept, robot.radius_of(), kept["map"])


def _draw(picture: Path, costmap: Any, answer: Mapping[str, Any], radius: float, name: str) -> None:
    import numpy as np  # noqa: PLC0415

    from robots.pictures.path import write_picture  # noqa: PLC0415

    facts = [f"{answer['length']:.2f} m", f"cost {answer['cost']:.0f}", f"{answer['seconds'] * 1e3:.1f} ms"]
    if "expanded" in answer:
        facts.append(f"{answer['expanded']} cells settled")
    title = f"{name}, planned by {answer['planner']}"
    write_picture(picture, costmap, np.array(answer["poses"]), radius=radius, title=title, facts=facts)


_VERBS = {"create": _create, "list": _list, "show": _show, "delete": _delete, **plan_database.VERBS}
