"""Command ``ppaas login``: obtains a token."""

import argparse
import sys

from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.password import add_password_argument, read_password
from robots.cli.session import add_url_argument, rest_client

NAME = "login"
HELP = "get a token: export PPAAS_TOKEN=$(ppaas login USER)"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("user")
    add_password_argument(parser)
    add_url_argument(parser)
    parser.add_argument("--json", action="store_true", help="print JSON with the token and its time of expiry")


def run(arguments: argparse.Namespace) -> int:
    """Print the token."""
    password = read_password(arguments.user, arguments.password_file)
    login = event_loop.run(rest_client(arguments.url).login(arguments.user, password))
    if arguments.json:
        show({"token": login.token, "expires": login.expires}, (), as_json=True)
    else:
        sys.stdout.write(login.token + "\n")
    return 0
