"""Command ``ppaas audit``: shows who did what in the cloud, for administrators."""

import argparse
import datetime
import re
import time

from robots.cli import event_loop
from robots.cli.output import show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

NAME = "audit"
HELP = "show who did what, newest first (admin)"

COLUMNS = ("time", "user", "address", "action", "object", "outcome", "reason", "repeats", "details")
OUTCOMES = ("ok", "refused", "failed")
LIMIT = 50

_UNITS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.add_argument("--user", help="only events of this user")
    parser.add_argument("--action", help="only these actions, as remove_map or connect")
    parser.add_argument("--object", help="only events of this object and its parts, as robots/tb1")
    parser.add_argument("--outcome", choices=OUTCOMES, help="only events with this outcome")
    parser.add_argument(
        "--after", type=_moment, metavar="TIME", help="only events since then: 30m, 12h or 7d ago, or an ISO 8601 date"
    )
    parser.add_argument("--limit", type=_count, default=LIMIT, help="maximum number of events; 0: all (%(default)s)")
    add_session_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Print the events."""
    event_loop.run(_list(arguments))
    return 0


async def _list(arguments: argparse.Namespace) -> None:
    wanted = {name: getattr(arguments, name) for name in ("user", "action", "object", "outcome", "after")}
    filters = {name: value for name, value in wanted.items() if value is not None}
    events = await logged_in(arguments).items(path_of("audit"), arguments.limit or None, **filters)
    show(events, COLUMNS, as_json=arguments.json, if_none="no events")


def _count(text: str) -> int:
    count = int(text)
    if count < 0:
        raise argparse.ArgumentTypeError(f"must be 0 or more, not {count}")
    return count


def _moment(text: str) -> float:
    """Return a time [s since the epoch] from a time ago or a date, which is local unless it has a time zone."""
    ago = re.fullmatch(r"(\d{1,9})([smhd])", text)
    if ago is not None:
        return time.time() - int(ago[1]) * _UNITS[ago[2]]
    try:
        return datetime.datetime.fromisoformat(text).timestamp()
    except (ValueError, OverflowError) as error:
        raise argparse.ArgumentTypeError(f"give a time as 30m, 12h, 7d or 2026-01-31T12:00, not {text!r}") from error
