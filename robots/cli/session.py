"""Options and REST client that all commands of the cloud share: its URL and the user's token."""

import argparse
import os
from typing import TYPE_CHECKING, Any

from ppaas.errors import NotAuthenticated

if TYPE_CHECKING:
    from robots.client.rest import RestClient

DEFAULT_URL = "http://127.0.0.1:8500"
"""URL of a cloud on this computer."""


class _TrustFile(argparse.Action):
    """Trust the authorities in a file, in all clients of this process and of those that it starts."""

    def __call__(
        self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        """Check the file, and name it to OpenSSL, which would silently ignore an unusable one."""
        import ssl  # noqa: PLC0415 - takes 10 ms, which most commands need not spend

        try:
            ssl.create_default_context(cafile=values)
        except OSError as error:
            parser.error(f"cannot read certificates from {values}: {error}; give a file in PEM")
        os.environ["SSL_CERT_FILE"] = values
        setattr(namespace, self.dest, values)


def add_url_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--url``."""
    url = os.environ.get("PPAAS_URL", DEFAULT_URL)
    parser.add_argument("--url", default=url, help="URL of the cloud (PPAAS_URL, else %(default)s)")
    parser.add_argument(
        "--ca-file",
        action=_TrustFile,
        metavar="FILE",
        help="certificates in PEM to trust for https instead of those of the system (SSL_CERT_FILE)",
    )


def add_cloud_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options ``--url`` and ``--token``."""
    add_url_argument(parser)
    parser.add_argument("--token", default=os.environ.get("PPAAS_TOKEN"), help="token from 'ppaas login' (PPAAS_TOKEN)")


def add_session_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options ``--url``, ``--token`` and ``--json``."""
    add_cloud_arguments(parser)
    parser.add_argument("--json", action="store_true", help="print the complete response as JSON")


def add_limit_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--limit``."""
    parser.add_argument("--limit", type=_count, help="maximum number of items (all)")


def add_interval_argument(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--interval`` of a live view."""
    parser.add_argument(
        "--interval", type=seconds, default=1.0, metavar="SECONDS", help="time between updates (%(default)s)"
    )


def seconds(text: str) -> float:
    """Return the interval of a live view [s], for ``argparse``; ``ArgumentTypeError`` if it is out of range."""
    interval = float(text)
    if not 0.1 <= interval <= 3600.0:
        raise argparse.ArgumentTypeError(f"must be from 0.1 to 3600 seconds, not {text}")
    return interval


def _count(text: str) -> int:
    count = int(text)
    if count < 1:
        raise argparse.ArgumentTypeError(f"must be 1 or more, not {count}")
    return count


def token_of(arguments: argparse.Namespace) -> str:
    """Return the token of the arguments.

    Raises
    ------
    NotAuthenticated
        There is no token.
    """
    if not arguments.token:
        raise NotAuthenticated("no token: export PPAAS_TOKEN=$(ppaas login USER)")
    return str(arguments.token)


def rest_client(url: str, token: str | None = None) -> "RestClient":
    """Return a REST client."""
    # ``ppaas --help`` loads every command but must not load HTTP.
    from robots.client.rest import RestClient  # noqa: PLC0415

    return RestClient(url, token)


def logged_in(arguments: argparse.Namespace) -> "RestClient":
    """Return a REST client with the token of the arguments.

    Raises
    ------
    NotAuthenticated
        There is no token.
    """
    return rest_client(arguments.url, token_of(arguments))
