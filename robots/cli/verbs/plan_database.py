"""Verbs of ``ppaas plan`` for the path plan database: ``find``, ``set``, ``put``, ``parts`` and ``statistics``."""

import argparse
import json
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from ppaas.errors import InvalidInput
from robots.cli.output import show
from robots.cli.resource import merge_patch
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

FOUND = ("plan_id", "planner", "length", "cost", "seconds", "user", "robot", "created")
PARTS = ("entry", "first", "count", "plans")
STATISTICS = ("plans", "waypoints", "kept", "entries", "bytes")


def configure(verbs: Any) -> None:
    """Add the verbs to ``ppaas plan``."""
    find = verbs.add_parser("find", help="find the stored paths between two points, shortest first")
    find.add_argument("map", help="id of the map")
    for end in ("start", "goal"):
        find.add_argument(f"--{end}", nargs=2, type=float, required=True, metavar=("X", "Y"), help="point [m]")
    find.add_argument(
        "--tolerance",
        type=float,
        default=0.25,
        help="greatest distance of a path's ends from the points [m] (%(default)s)",
    )
    find.add_argument("--planner", help="only paths of this planner")
    find.add_argument("--limit", type=int, default=16, metavar="N", help="maximum number of paths (%(default)s)")
    change = verbs.add_parser("set", help="change fields of a stored path")
    change.add_argument("id")
    change.add_argument("changes", nargs="+", metavar="NAME=VALUE", help="planner, cost, seconds, parameters.NAME …")
    put = verbs.add_parser("put", help="store a path under an id, replacing the one there")
    put.add_argument("id")
    put.add_argument("file", type=Path, help='JSON: {"map": …, "planner": …, "poses": [[x, y, z, qx, qy, qz, qw], …]}')
    parts = verbs.add_parser("parts", help="show the segments of a path that are shared with other paths")
    parts.add_argument("id")
    statistics = verbs.add_parser("statistics", help="show the number of stored paths of a map, and their size")
    statistics.add_argument("map", help="id of the map")
    for verb in (find, change, put, parts, statistics):
        add_session_arguments(verb)


async def _find(arguments: argparse.Namespace) -> None:
    query_of = {"map": arguments.map, "tolerance": arguments.tolerance, "limit": arguments.limit}
    query_of |= {end: ",".join(map(repr, getattr(arguments, end))) for end in ("start", "goal")}
    if arguments.planner is not None:
        query_of["planner"] = arguments.planner
    query = urlencode(query_of, errors="surrogateescape")
    found = await logged_in(arguments).get(f"{path_of('plans')}?{query}")
    show(found["items"], FOUND, as_json=arguments.json, if_none="no stored paths between these points")


async def _set(arguments: argparse.Namespace) -> None:
    changed = await logged_in(arguments).patch(path_of("plans", arguments.id), merge_patch(arguments.changes))
    show(changed, FOUND, as_json=arguments.json)


async def _put(arguments: argparse.Namespace) -> None:
    stored = await logged_in(arguments).put(path_of("plans", arguments.id), _read(arguments.file))
    show(stored, FOUND, as_json=arguments.json)


async def _parts(arguments: argparse.Namespace) -> None:
    found = await logged_in(arguments).get(path_of("plans", arguments.id, "parts"))
    show(found["items"], PARTS, as_json=arguments.json, if_none="the path is too short to have shared segments")


async def _statistics(arguments: argparse.Namespace) -> None:
    found = await logged_in(arguments).get(path_of("maps", arguments.map, "plan_statistics"))
    show(found, STATISTICS, as_json=arguments.json)


def _read(file: Path) -> Any:
    try:
        return json.loads(file.read_bytes())
    except OSError as error:
        raise InvalidInput(f"cannot read {file}: {error.strerror}") from error
    except ValueError as error:
        raise InvalidInput(f"{file} is not JSON: {error}") from error


VERBS = {"find": _find, "set": _set, "put": _put, "parts": _parts, "statistics": _statistics}
