"""``ppaas user``: who may use the cloud."""

import argparse
import asyncio
from urllib.parse import quote

from robots.commands.password import add_password_argument, read_password
from robots.commands.session import add_session_arguments, logged_in
from robots.commands.table import show

NAME = "user"
HELP = "add, list and delete users (admin); show who you are"

COLUMNS = ("id", "role")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    add = verbs.add_parser("add", help="add a user (admin)")
    listing = verbs.add_parser("list", help="list all users (admin)")
    me = verbs.add_parser("me", help="show whose token you have")
    delete = verbs.add_parser("delete", help="delete a user with tokens and robots (admin)")
    for verb in (add, delete):
        verb.add_argument("id")
    add_password_argument(add)
    add.add_argument("--role", default="user", choices=["user", "admin"], help="(%(default)s)")
    for verb in (add, listing, me, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Carry out the verb."""
    asyncio.run(_VERBS[arguments.verb](arguments))
    return 0


async def _add(arguments: argparse.Namespace) -> None:
    client = logged_in(arguments)
    password = read_password(arguments.id, arguments.password_file)
    user = await client.post("/v1/users", {"id": arguments.id, "password": password, "role": arguments.role})
    show(user, COLUMNS, as_json=arguments.json)


async def _list(arguments: argparse.Namespace) -> None:
    show(await logged_in(arguments).get("/v1/users"), COLUMNS, as_json=arguments.json)


async def _me(arguments: argparse.Namespace) -> None:
    show(await logged_in(arguments).get("/v1/users/me"), COLUMNS, as_json=arguments.json)


async def _delete(arguments: argparse.Namespace) -> None:
    await logged_in(arguments).delete(f"/v1/users/{quote(arguments.id, safe='')}")


_VERBS = {"add": _add, "list": _list, "me": _me, "delete": _delete}
