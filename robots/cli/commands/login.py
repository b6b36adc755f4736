"""Command ``ppaas login``: obtains a token."""

import argparse
import sys
from pathlib import Path
from typing import Any

from ppaas.clock import monotonic
from ppaas.errors import InvalidInput, NotAuthenticated
from robots.cli import event_loop
from robots.cli.output import printable, show
from robots.cli.password import add_password_argument, read_password, read_secret
from robots.cli.session import add_url_argument, rest_client
from robots.client.cloud_url import path_of

NAME = "login"
HELP = "get a token: export PPAAS_TOKEN=$(ppaas login USER)"

LEAST_INTERVAL = 0.2
"""Least time between two questions whether somebody has logged in [s]."""

SLOWER = 5.0
"""Time by which that grows if the identity provider wants it (RFC 8628, 3.5) [s]."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("user", nargs="?", help="user with a password; leave it out with the options below")
    add_password_argument(parser)
    others = parser.add_mutually_exclusive_group()
    others.add_argument(
        "--oidc", action="store_true", help="log in with the identity provider of the cloud, in a browser anywhere"
    )
    others.add_argument(
        "--access-token-file", type=Path, metavar="FILE",
        help="file with an access token of the identity provider for this cloud, as of a program ('-': standard input)",
    )  # fmt: skip
    add_url_argument(parser)
    parser.add_argument("--json", action="store_true", help="print JSON with the token and its time of expiry")


def run(arguments: argparse.Namespace) -> int:
    """Print the token."""
    login = event_loop.run(_login(arguments))
    if arguments.json:
        show({"token": login["token"], "expires": login["expires"]}, (), as_json=True)
    else:
        sys.stdout.write(login["token"] + "\n")
    return 0


async def _login(arguments: argparse.Namespace) -> dict[str, Any]:
    client = rest_client(arguments.url)
    by_provider = arguments.oidc or arguments.access_token_file is not None
    if by_provider == (arguments.user is not None):
        raise InvalidInput("give a user, or --oidc, or --access-token-file: one of them")
    if arguments.oidc:
        return await _by_device(client)
    if by_provider:
        token = read_secret("access token", arguments.access_token_file)
        answer: dict[str, Any] = await client.post(path_of("oidc", "access-tokens"), {"access_token": token})
        return answer
    login = await client.login(arguments.user, read_password(arguments.user, arguments.password_file))
    return {"token": login.token, "expires": login.expires}


async def _by_device(client: Any) -> dict[str, Any]:
    import asyncio  # noqa: PLC0415 - ``ppaas --help`` loads this module

    code = await client.post(path_of("oidc", "devices"), {})
    where = code["verification_uri_complete"] or code["verification_uri"]
    sys.stderr.write(f"open {printable(where)} and log in; the code is {printable(code['user_code'])}\n")
    interval, until = max(code["interval"], LEAST_INTERVAL), monotonic() + code["expires_in"]
    while monotonic() < until:
        await asyncio.sleep(interval)
        answer: dict[str, Any] = await client.post(
            path_of("oidc", "device-tokens"), {name: code[name] for name in ("device_code", "verifier")}
        )
        if "token" in answer:
            return answer
        interval += SLOWER if answer["slower"] else 0.0
    raise NotAuthenticated(f"nobody has logged in within {code['expires_in']:g} s: begin again")
