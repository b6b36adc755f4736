"""Verb ``ppaas robot list``: robots with their states, in the columns of the dashboard's table, as ``ppaas top``."""

import argparse
import re
from collections.abc import Sequence
from typing import Any

from robots.cli.output import show
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

Row = dict[str, Any]

COLUMNS = ("id", "state", "battery", "seen_ago", "task", "error", "map", "machine", "software")
"""Columns of a list of robots, as in the dashboard's table. Their meaning is that of ``GET /v1/robots``."""

SHORT = COLUMNS[:6]
"""Columns that fit a terminal."""

FILE = ("connected", "model", "initial_pose", "cores", "base_global_planner", "base_local_planner", "stopped")
"""Columns of the robot files, whether the robot is connected, and what stops it."""

LONGEST = 40
"""Length to which a text is cut for a terminal [characters]."""

NONE, NONE_SHARED = "no robots; register one: ppaas robot put ID FILE.json", "no robots are shared with you"
NONE_FOUND = "no robot is found"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the verb."""
    parser.add_argument("--shared", action="store_true", help="list the robots that others share with you instead")
    parser.add_argument("--wide", action="store_true", help="show all columns, and texts in full")
    parser.add_argument("--sort", choices=COLUMNS, help="sort by a column; empty ones come last")
    parser.add_argument("--reverse", action="store_true", help="with --sort: from the largest to the smallest")
    parser.add_argument("--filter", default="", metavar="TEXT", help="list robots in which each word of it is found")
    add_limit_argument(parser)
    add_session_arguments(parser)


async def run(arguments: argparse.Namespace) -> None:
    """Execute the verb."""
    query = {"shared": "true"} if arguments.shared else {}
    found = await logged_in(arguments).items(path_of("robots"), arguments.limit, **query)
    rows = matching(found, arguments.filter)
    if arguments.sort is not None:
        rows = in_order(rows, arguments.sort, falls=arguments.reverse)
    owner = ("user", "role") if arguments.shared else ()
    none = NONE_FOUND if found else NONE_SHARED if arguments.shared else NONE
    if arguments.json or arguments.wide:
        show(rows, (*owner, *COLUMNS, *FILE), as_json=arguments.json, if_none=none)
    else:
        show(list(map(short, rows)), (*owner, *SHORT), as_json=False, if_none=none)


def matching(robots: Sequence[Row], text: str) -> list[Row]:
    """Return the robots in whose columns each word of a text is found, in any case."""
    words = text.lower().split()
    return [robot for robot in robots if all(word in _whole(robot) for word in words)]


def _whole(robot: Row) -> str:
    return "\n".join(str(robot.get(column) or "") for column in COLUMNS).lower()


def in_order(robots: Sequence[Row], column: str, *, falls: bool = False) -> list[Row]:
    """Return robots by a column: numbers in names by their value, what is not known last, and equal ones by id."""
    by_id = sorted(robots, key=lambda robot: _parts(robot["id"]))
    known = [robot for robot in by_id if robot.get(column) not in (None, "")]
    unknown = [robot for robot in by_id if robot.get(column) in (None, "")]
    return [*sorted(known, key=lambda robot: _key(robot[column]), reverse=falls), *unknown]


def _key(value: Any) -> Any:
    return _parts(value) if isinstance(value, str) else value


def _parts(name: str) -> list[tuple[bool, int, str]]:
    """Return a sort key of a text, in which numbers count by their value: tb9 comes before tb10."""
    parts = re.split(r"(\d+)", name.lower())
    return [(part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts if part]


def short(robot: Row) -> Row:
    """Return a robot with its texts cut to what fits a terminal."""
    texts = {name: _cut(value) for name in ("task", "error") if isinstance(value := robot.get(name), str)}
    return robot | texts


def _cut(text: str) -> str:
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"
