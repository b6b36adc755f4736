"""Command ``ppaas user``: users of the cloud, their groups, quotas and passwords of Rapyuta."""

import argparse
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput, NotFound
from robots.cli import event_loop
from robots.cli.output import print_line, show, table
from robots.cli.password import add_password_argument, read_password
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient


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


# -- identities, with which users log in by an identity provider -------------------------------------------------------


def add_link_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of the verb."""
    parser.add_argument("subject", nargs="?", help="who it is there: the subject (sub) of its tokens")
    parser.add_argument("--issuer", metavar="URL", help="the identity provider, as its tokens name it")
    parser.add_argument("--off", action="store_true", help="nobody logs in as the user by it any more")


async def link_user(arguments: argparse.Namespace) -> None:
    """Link a user to an identity, or to none."""
    given = [arguments.subject is not None, arguments.issuer is not None]
    if any(given) if arguments.off else not all(given):
        raise InvalidInput("give a subject with --issuer URL, or --off alone")
    identity = None if arguments.off else {"issuer": arguments.issuer, "subject": arguments.subject}
    changed = await logged_in(arguments).patch(path_of("users", arguments.id), {"identity": identity})
    show(changed, ("id", "role", "identity"), as_json=arguments.json)


# -- quotas of users in ``ppaas user`` ---------------------------------------------------------------------------------

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
    link = verbs.add_parser("link", help="let somebody log in as a user with the identity provider (admin)")
    logout = verbs.add_parser("logout", help="revoke all tokens of a user (you), and disconnect all robots")
    for verb in (create, limits, delete, rapyuta, link):
        verb.add_argument("id")
    delete.add_argument("--force", action="store_true", help="disconnect the user's robots")
    add_limit_options(limits)
    add_rapyuta_options(rapyuta)
    add_link_options(link)
    for verb in (one, change, logout):
        verb.add_argument("id", nargs="?", default=ME, help="(you)")
    add_password_argument(create)
    create.add_argument("--role", default="user", choices=ROLES, help="(%(default)s)")
    configure_group(verbs.add_parser("group", help="list, show or change groups of users (admin)"))
    add_limit_argument(listing)
    change.add_argument("--role", choices=ROLES)
    change.add_argument(
        "--password", action="store_true", help="prompt for the new password, and for the old one if it is yours"
    )
    add_password_argument(change)
    change.add_argument("--old-password-file", type=Path, help="file with your current password")
    for verb in (create, listing, one, change, limits, rapyuta, link, delete, logout):
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


# -- groups of users, with which robots are shared ---------------------------------------------------------------------

GROUP_COLUMNS = ("id", "members")
NONE = "no groups; create one: ppaas user group NAME --add USER"


def configure_group(parser: argparse.ArgumentParser) -> None:
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
        show(await client.items(path_of("groups")), GROUP_COLUMNS, as_json=arguments.json, if_none=NONE)
        return
    path = path_of("groups", arguments.group)
    if arguments.delete:
        if changed:
            raise InvalidInput("a group that is deleted is not changed: give --delete alone")
        await client.delete(path)
        return
    if not changed:
        show(await client.get(path), GROUP_COLUMNS, as_json=arguments.json)
        return
    try:
        members = set((await client.get(path))["members"])
    except NotFound:
        members = set()
    members = (members | set(arguments.add)) - set(arguments.remove)
    if not members:
        raise InvalidInput(f"group {arguments.group!r} would have no members: delete it with --delete")
    show(await client.put(path, {"members": sorted(members)}), GROUP_COLUMNS, as_json=arguments.json)


_VERBS = {
    "create": _create,
    "list": USERS.list,
    "show": show_user,
    "change": _change,
    "limit": limit,
    "delete": _delete,
    "logout": _logout,
    "group": group,
    "rapyuta": set_rapyuta_password,
    "link": link_user,
}
