"""Command ``ppaas retention``: for how long a cloud keeps data, and what has expired, for administrators."""

import argparse
from typing import Any

from ppaas.errors import Unavailable
from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "retention"
HELP = "show for how long the cloud keeps data, and remove what has expired (admin)"

COLUMNS = ("kind", "days", "gigabytes", "last_run", "removed", "text")
EXPIRED_COLUMNS = ("kind", "before", "expired", "fault")


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "The cloud removes what has expired once a day. 'ppaas up --retention' sets the days of each kind, and "
        "'--retention-size' the size of recordings."
    )
    verbs = parser.add_subparsers(dest="verb", required=True, metavar="VERB")
    shown = verbs.add_parser("show", help="show for how long each kind of data is kept")
    run_now = verbs.add_parser("run", help="remove what has expired now; exit with 1 if something could not be removed")
    run_now.add_argument("--dry-run", action="store_true", help="only count what has expired")
    for verb in (shown, run_now):
        add_session_arguments(verb)


def run(arguments: argparse.Namespace) -> int:
    """Execute the verb."""
    event_loop.run(_VERBS[arguments.verb](arguments))
    return 0


async def _show(arguments: argparse.Namespace) -> None:
    found = await logged_in(arguments).get(path_of("retention"))
    show(found, COLUMNS, as_json=arguments.json)


async def _run(arguments: argparse.Namespace) -> None:
    found: list[dict[str, Any]] = await logged_in(arguments).post(path_of("retention"), {"dry_run": arguments.dry_run})
    show(found, EXPIRED_COLUMNS, as_json=arguments.json)
    if any(one["fault"] for one in found):
        raise Unavailable("not everything that has expired could be removed: see the column fault")


_VERBS = {"show": _show, "run": _run}
