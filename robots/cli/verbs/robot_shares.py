"""Verbs ``share`` and ``unshare`` of ``ppaas robot``: with whom a robot is shared, and for what."""

import argparse
from typing import Any

from ppaas.errors import InvalidInput
from robots.cli.output import show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

ROLES = ("look", "drive", "administer")
COLUMNS = ("to", "role", "publish", "subscribe")
NONE = "the robot is not shared; share it: ppaas robot share ID --with USER --role drive"


def configure_share(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``share``."""
    parser.add_argument("id", help="id of the robot; OWNER:ID for one of another user")
    _add_grantee(parser, "share it with them; without this option, list with whom it is shared")
    parser.add_argument("--role", choices=ROLES, help="what they may do")
    add_topic_options(parser)
    add_session_arguments(parser)


def configure_unshare(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``unshare``."""
    parser.add_argument("id", help="id of the robot; OWNER:ID to leave a robot that is shared with you")
    _add_grantee(parser, "share it no more with them", required=True)
    add_session_arguments(parser)


def add_topic_options(parser: argparse.ArgumentParser) -> None:
    """Add options for globs of topics, which may be repeated."""
    parser.add_argument(
        "--publish", action="append", metavar="GLOB",
        help="topics to publish, services to call and actions to send goals to, as 'cmd_vel' (all; none for look)",
    )  # fmt: skip
    parser.add_argument(
        "--subscribe", action="append", metavar="GLOB",
        help="topics to subscribe to, and services that only read (all)",
    )  # fmt: skip


def topics_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return the globs of topics that were given, as a part of a request."""
    given = {"publish": arguments.publish, "subscribe": arguments.subscribe}
    return {name: globs for name, globs in given.items() if globs is not None}


async def share(arguments: argparse.Namespace) -> None:
    """Share a robot, or list with whom it is shared."""
    client, path = logged_in(arguments), path_of("robots", arguments.id, "shares")
    topics = topics_of(arguments)
    if arguments.grantee is None:
        if arguments.role is not None or topics:
            raise InvalidInput("say with whom: --with USER, or --with group:NAME")
        show(await client.items(path), COLUMNS, as_json=arguments.json, if_none=NONE)
        return
    if arguments.role is None:
        raise InvalidInput(f"say what for: --role {' or --role '.join(ROLES)}")
    shared = await client.put(
        path_of("robots", arguments.id, "shares", arguments.grantee), {"role": arguments.role, **topics}
    )
    show(shared, COLUMNS, as_json=arguments.json)


async def unshare(arguments: argparse.Namespace) -> None:
    """Share a robot no more with a user or a group."""
    await logged_in(arguments).delete(path_of("robots", arguments.id, "shares", arguments.grantee))


def _add_grantee(parser: argparse.ArgumentParser, meaning: str, *, required: bool = False) -> None:
    parser.add_argument("--with", dest="grantee", required=required, metavar="USER|group:NAME", help=meaning)
