"""``ppaas plan find|set|put|parts|statistics``: the Path Plan Database of a cloud."""

import argparse
import json
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from ppaas.errors import InvalidInput
from robots.cli.output import show
from robots.cli.resource import merge_patch
from robots.cli.session import add_session_arguments, logged_in
from robots.client.rest_paths import path_of

FOUND = ("plan_id", "planner", "length", "cost", "seconds", "user", "robot", "created")
PARTS = ("entry", "first", "count", "plans")
STATISTICS = ("plans", "waypoints", "kept", "entries", "bytes")


def configure(verbs: Any) -> None:
    """Add the verbs to those of ``ppaas plan``."""
    find = verbs.add_parser("find", help="find the paths kept between two places, the shortest first")
    find.add_argument("map", help="id of the map")
    for end in ("start", "goal"):
        find.add_argument(f"--{end}", nargs=2, type=float, required=True, metavar=("X", "Y"), help="in metres")
    find.add_argument("--tolerance", type=float, default=0.25, help="metres that an end may be off (%(default)s)")
    find.add_argument("--planner", help="of this planner alone")
    find.add_argument("--limit", type=int, default=16, metavar="N", help="(%(default)s)")
    change = verbs.add_parser("set", help="change some of a path that was kept")
    change.add_argument("id")
    change.add_argument("changes", nargs="+", metavar="NAME=VALUE", help="planner, cost, seconds, parameters.NAME …")
    put = verbs.add_parser("put", help="keep a path under an id, or in place of the one of that id")
    put.add_argument("id")
    put.add_argument("file", type=Path, help='JSON: {"map": …, "planner": …, "poses": [[x, y, z, qx, qy, qz, qw], …]}')
    parts = verbs.add_parser("parts", help="tell which stretches of a path are kept once for all that share them")
    parts.add_argument("id")
    statistics = verbs.add_parser("statistics", help="tell how many paths are kept on a map, and what they take")
    statistics.add_argument("map", help="id of the map")
    for verb in (find, change, put, parts, statistics):
        add_session_arguments(verb)


async def _find(arguments: argparse.Namespace) -> None:
    sought = {"map": arguments.map, "tolerance": arguments.tolerance, "limit": arguments.limit}
    sought |= {end: ",".join(map(repr, getattr(arguments, end))) for end in ("start", "goal")}
    if arguments.planner is not None:
        sought["planner"] = arguments.planner
    query = urlencode(sought, errors="surrogateescape")
    found = await logged_in(arguments).get(f"{path_of('plans')}?{query}")
    show(found["items"], FOUND, as_json=arguments.json, if_none="no paths between these places")


async def _set(arguments: argparse.Namespace) -> None:
    changed = await logged_in(arguments).patch(path_of("plans", arguments.id), merge_patch(arguments.changes))
    show(changed, FOUND, as_json=arguments.json)


async def _put(arguments: argparse.Namespace) -> None:
    kept = await logged_in(arguments).put(path_of("plans", arguments.id), _read(arguments.file))
    show(kept, FOUND, as_json=arguments.json)


async def _parts(arguments: argparse.Namespace) -> None:
    told = await logged_in(arguments).get(path_of("plans", arguments.id, "parts"))
    show(told["items"], PARTS, as_json=arguments.json, if_none="the path is too short to share anything")


async def _statistics(arguments: argparse.Namespace) -> None:
    told = await logged_in(arguments).get(path_of("maps", arguments.map, "plan_statistics"))
    show(told, STATISTICS, as_json=arguments.json)


def _read(file: Path) -> Any:
    try:
        return json.loads(file.read_bytes())
    except OSError as error:
        raise InvalidInput(f"{file}: {error.strerror}") from error
    except ValueError as error:
        raise InvalidInput(f"{file} is no JSON: {error}") from error


VERBS = {"find": _find, "set": _set, "put": _put, "parts": _parts, "statistics": _statistics}
