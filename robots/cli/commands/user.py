"""Command ``ppaas user``: users of the cloud and their quotas."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.password import add_password_argument, read_password
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.cli.verbs import user_groups
from robots.cli.verbs.user_limits import add_limit_options, limit, show_user
from robots.cli.verbs.user_rapyuta import add_rapyuta_options, set_rapyuta_password
from robots.client.rest_paths import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

NAME = "user"
HELP = "create, list, show, change, limit and delete users; change your password"

USERS = Resource("users", ("id", "role"), "no users", ("id", "role", "groups"))
ROLES = ("user", "admin")
ME = "me"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    create = verbs.add_parser("create", help="create a user (admin)")
    listing = verbs.add_parser("list", help="list all users (admin)")
    one = verbs.add_parser("show", help="show a user (you), with quotas and usage")
    change = verbs.add_parser("change", help="change a password, or a role (admin)")
    limits = verbs.add_parser("limit", help="change the quotas of a user (admin)")
    delete = verbs.add_parser("delete", help="delete a user with all tokens and robots (admin)")
    rapyuta = verbs.add_parser("rapyuta", help="let robots of a user log in by the protocol of Rapyuta (admin)")
    logout = verbs.add_parser("logout", help="revoke all tokens of a user (you), and disconnect all robots")
    for verb in (create, limits, delete, rapyuta):
        verb.add_argument("id")
    delete.add_argument("--force", action="store_true", help="disconnect the user's robots")
    add_limit_options(limits)
    add_rapyuta_options(rapyuta)
    for verb in (one, change, logout):
        verb.add_argument("id", nargs="?", default=ME, help="(you)")
    add_password_argument(create)
    create.add_argument("--role", default="user", choices=ROLES, help="(%(default)s)")
    user_groups.configure(verbs.add_parser("group", help="list, show or change groups of users (admin)"))
    add_limit_argument(listing)
    change.add_argument("--role", choices=ROLES)
    change.add_argument(
        "--password", action="store_true", help="prompt for the new password, and for the old one if it is yours"
    )
    add_password_argument(change)
    change.add_argument("--old-password-file", type=Path, help="file with your current password")
    for verb in (create, listing, one, change, limits, rapyuta, delete, logout):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _create(arguments: argparse.Namespace) -> None:
    client = logged_in(arguments)
    password = read_password(arguments.id, arguments.password_file)
    user = await client.post(path_of("users"), {"id": arguments.id, "password": password, "role": arguments.role})
    show(user, USERS.columns, as_json=arguments.json)


async def _delete(arguments: argparse.Namespace) -> None:
    query = "?force=true" if arguments.force else ""
    await logged_in(arguments).delete(path_of("users", arguments.id) + query)


async def _logout(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(path_of("users", arguments.id, "sessions"))


async def _change(arguments: argparse.Namespace) -> None:
    wants_password = arguments.password or arguments.password_file is not None
    if not wants_password and arguments.role is None:
        raise InvalidInput("nothing to change; give --password or --role")
    client = logged_in(arguments)
    change: dict[str, Any] = {} if arguments.role is None else {"role": arguments.role}
    if wants_password:
        change |= await _passwords(client, arguments)
    show(await client.patch(path_of("users", arguments.id), change), USERS.columns, as_json=arguments.json)


async def _passwords(client: "RestClient", arguments: argparse.Namespace) -> dict[str, str]:
    """Read the new password of a user, and first the old one if users change their own."""
    me = (await client.get(path_of("users", ME)))["id"]
    if arguments.id not in (ME, me):
        return {"password": read_password(arguments.id, arguments.password_file)}
    old = read_password(f"{me} (current)", arguments.old_password_file)
    return {"old_password": old, "password": read_password(f"{me} (new)", arguments.password_file)}


_VERBS = {
    "create": _create,
    "list": USERS.list,
    "show": show_user,
    "change": _change,
    "limit": limit,
    "delete": _delete,
    "logout": _logout,
    "group": user_groups.group,
    "rapyuta": set_rapyuta_password,
}
