"""Verb ``group`` of ``ppaas user``: groups of users, with which robots are shared."""

import argparse

from ppaas.errors import InvalidInput, NotFound
from robots.cli.output import show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.rest_paths import path_of

COLUMNS = ("id", "members")
NONE = "no groups; create one: ppaas user group NAME --add USER"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("group", nargs="?", help="name of a group; without it, list all groups (admin)")
    parser.add_argument("--add", nargs="+", default=[], metavar="USER", help="add users; the first create the group")
    parser.add_argument("--remove", nargs="+", default=[], metavar="USER", help="remove users")
    parser.add_argument("--delete", action="store_true", help="delete the group; nothing is shared with it any more")
    add_session_arguments(parser)


async def group(arguments: argparse.Namespace) -> None:
    """List, show, change or delete groups."""
    client, changed = logged_in(arguments), {*arguments.add, *arguments.remove}
    if arguments.group is None:
        if changed or arguments.delete:
            raise InvalidInput("name the group to change: ppaas user group NAME")
        show(await client.items(path_of("groups")), COLUMNS, as_json=arguments.json, if_none=NONE)
        return
    path = path_of("groups", arguments.group)
    if arguments.delete:
        if changed:
            raise InvalidInput("a group that is deleted is not changed: give --delete alone")
        await client.delete(path)
        return
    if not changed:
        show(await client.get(path), COLUMNS, as_json=arguments.json)
        return
    try:
        members = set((await client.get(path))["members"])
    except NotFound:
        members = set()
    members = (members | set(arguments.add)) - set(arguments.remove)
    if not members:
        raise InvalidInput(f"group {arguments.group!r} would have no members: delete it with --delete")
    show(await client.put(path, {"members": sorted(members)}), COLUMNS, as_json=arguments.json)
