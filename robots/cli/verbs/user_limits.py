"""Quotas of users in ``ppaas user``: shows and changes them."""

import argparse
import math
from typing import Any

from ppaas.errors import InvalidInput
from robots.cli.output import print_line, show, table
from robots.cli.session import logged_in
from robots.client.rest_paths import path_of

DEFAULT = "default"
COLUMNS = ("quota", "used", "limit", "own")
LIMITS = {
    "containers": "running containers: clones, planning, coordinators of people and traffic nodes",
    "cores": "CPU cores of these containers together",
    "robots": "registered robots",
    "maps": "maps owned",
    "plans_per_minute": "paths requested per minute",
    "stored_bytes": "bytes of map files and URDFs",
    "versions_per_map": "versions of one map",
}


def add_limit_options(parser: argparse.ArgumentParser) -> None:
    """Add an option for each quota."""
    for name, meaning in LIMITS.items():
        kind = _cores if name == "cores" else _count
        text = f"{meaning}; '{DEFAULT}' for the limit that applies to all users"
        parser.add_argument(f"--{name.replace('_', '-')}", type=kind, metavar="NUMBER", help=text)


async def limit(arguments: argparse.Namespace) -> None:
    """Change the quotas of a user."""
    given = {name: getattr(arguments, name) for name in LIMITS if getattr(arguments, name) is not None}
    if not given:
        raise InvalidInput("nothing to change; give a limit, as --containers 8 or --containers default")
    limits = {name: None if value == DEFAULT else value for name, value in given.items()}
    user = await logged_in(arguments).patch(path_of("users", arguments.id), {"limits": limits})
    show_detail(user, arguments)


async def show_user(arguments: argparse.Namespace) -> None:
    """Show a user with quotas and usage."""
    show_detail(await logged_in(arguments).get(path_of("users", arguments.id)), arguments)


def show_detail(user: dict[str, Any], arguments: argparse.Namespace) -> None:
    """Print a user with quotas and usage."""
    show(user, ("id", "role"), as_json=arguments.json)
    if arguments.json:
        return
    rows = [
        {"quota": name, "used": user["used"][name], "limit": user["quota"][name], "own": user["limits"][name]}
        for name in LIMITS
    ]
    print_line("")
    for line in table(rows, COLUMNS):
        print_line(line)


def _count(text: str) -> int | str:
    if text == DEFAULT:
        return DEFAULT
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be a whole number of 0 or more, or {DEFAULT!r}, not {text!r}")
    return int(text)


def _cores(text: str) -> float | str:
    if text == DEFAULT:
        return DEFAULT
    cores = float(text)
    if not (math.isfinite(cores) and cores >= 0.0):
        raise argparse.ArgumentTypeError(f"must be a number of cores of 0 or more, or {DEFAULT!r}, not {text!r}")
    return cores
