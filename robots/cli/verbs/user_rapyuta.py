"""Verb ``ppaas user rapyuta``: the password by which robots of a user log in by the protocol of Rapyuta."""

import argparse

from robots.cli.output import show
from robots.cli.password import add_password_argument, read_password
from robots.cli.session import logged_in
from robots.client.rest_paths import path_of


def add_rapyuta_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    add_password_argument(parser)
    parser.add_argument("--off", action="store_true", help="remove the password: no robot logs in by it any more")


async def set_rapyuta_password(arguments: argparse.Namespace) -> None:
    """Set or remove the password."""
    client = logged_in(arguments)
    password = None
    if not arguments.off:
        password = read_password(f"robots of {arguments.id}", arguments.password_file)
    changed = await client.patch(path_of("users", arguments.id), {"rapyuta_password": password})
    show(changed, ("id", "role", "rapyuta"), as_json=arguments.json)
