"""Command ``ppaas token``: tokens for some robots only, and the tokens that ``ppaas login`` creates."""

import argparse

from robots.cli import event_loop
from robots.cli.resource import Resource
from robots.cli.session import add_limit_argument, add_session_arguments
from robots.cli.verbs import token_scope

NAME = "token"
HELP = "create tokens for some robots, list your tokens, and delete them to log out"

TOKENS = Resource("tokens", ("id", "name", "created", "expires", "current", "scope"), "no tokens")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    listing = verbs.add_parser("list", help="list your tokens")
    delete = verbs.add_parser("delete", help="delete a token; its holder must log in again")
    token_scope.configure(verbs.add_parser("create", help="create a token for some robots only"))
    add_limit_argument(listing)
    delete.add_argument("id", help="id of the token; 'current' for the one in use")
    for verb in (listing, delete):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


_VERBS = {"create": token_scope.create, "list": TOKENS.list, "delete": TOKENS.delete}
