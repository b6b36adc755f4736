"""What all client commands share: which cloud, and who asks."""

import argparse
import os
from typing import TYPE_CHECKING

from ppaas.errors import NotAuthenticated

if TYPE_CHECKING:
    from robots.client.rest import RestClient

DEFAULT_URL = "http://127.0.0.1:8500"


def add_url_argument(parser: argparse.ArgumentParser) -> None:
    """Add which cloud."""
    url = os.environ.get("PPAAS_URL", DEFAULT_URL)
    parser.add_argument("--url", default=url, help="of the cloud (PPAAS_URL, else %(default)s)")


def add_cloud_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which cloud, and who asks."""
    add_url_argument(parser)
    parser.add_argument("--token", default=os.environ.get("PPAAS_TOKEN"), help="from 'ppaas login' (PPAAS_TOKEN)")


def add_session_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which cloud, who asks, and how the answer is shown."""
    add_cloud_arguments(parser)
    parser.add_argument("--json", action="store_true", help="print JSON, with all that the cloud tells")


def add_limit_argument(parser: argparse.ArgumentParser) -> None:
    """Add how much of a list is wanted."""
    parser.add_argument("--limit", type=_count, help="most items (all)")


def _count(text: str) -> int:
    count = int(text)
    if count < 1:
        raise argparse.ArgumentTypeError(f"give 1 or more, not {count}")
    return count


def token_of(arguments: argparse.Namespace) -> str:
    """Return the token given.

    Raises
    ------
    NotAuthenticated
        There is none.
    """
    if not arguments.token:
        raise NotAuthenticated("no token: export PPAAS_TOKEN=$(ppaas login USER)")
    return str(arguments.token)


def rest_client(url: str, token: str | None = None) -> "RestClient":
    """Return a client of the REST service."""
    # ``ppaas --help`` loads every command, and none of them HTTP for it.
    from robots.client.rest import RestClient  # noqa: PLC0415

    return RestClient(url, token)


def logged_in(arguments: argparse.Namespace) -> "RestClient":
    """Return a client with the token given.

    Raises
    ------
    NotAuthenticated
        There is none.
    """
    return rest_client(arguments.url, token_of(arguments))
