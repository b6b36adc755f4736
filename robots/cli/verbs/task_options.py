"""Options of tasks at the command line: holds, start times, other tasks that come first, and repeats."""

import argparse
from datetime import datetime
from typing import Any

from ppaas.errors import InvalidInput

ENDS = ("done", "failed", "ended")
DAYS = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a task that are not places."""
    parser.add_argument(
        "--hold",
        action="append",
        default=[],
        metavar="NUMBER[=SECONDS]",
        help="wait at the place of this number, from 1, until it is confirmed, or for a time",
    )
    parser.add_argument("--robot", dest="named_robot", help="the only robot that may do it")
    parser.add_argument("--weight", type=float, metavar="KG", help="weight to load; robots have a property 'payload'")
    parser.add_argument(
        "--start", metavar="TIME", help="no robot begins it earlier: 2026-12-01T08:30, local, or with offset"
    )
    parser.add_argument(
        "--after",
        action="append",
        metavar="TASK[=END]",
        help=f"begin after another task is done, or ends otherwise: {', '.join(ENDS)}",
    )
    parser.add_argument(
        "--preempt", action="store_true", help="take a robot from a task of lower priority, if no other is free"
    )
    parser.add_argument("--repeat-at", nargs="+", metavar="HH:MM", help="do it again at these times of day")
    parser.add_argument("--days", nargs="+", choices=DAYS, help="only on these days of the week")
    parser.add_argument("--zone", help="time zone of --repeat-at, such as Europe/Berlin (UTC)")
    parser.add_argument("--repeat-every", type=float, metavar="SECONDS", help="do it again after this time")
    parser.add_argument("--times", type=int, metavar="N", help="number of runs of a task that repeats")


def options_of(arguments: argparse.Namespace, places: int) -> dict[str, Any]:
    """Return the options of a task of so many places, as REST takes them.

    Raises
    ------
    InvalidInput
        An option is malformed.
    """
    fields: dict[str, Any] = {
        "named_robot": arguments.named_robot,
        "weight": arguments.weight,
        "not_before": None if arguments.start is None else _time(arguments.start),
        "after": [_after(text) for text in arguments.after] if arguments.after else None,
        "preempts": arguments.preempt or None,
        "holds": _holds(arguments.hold, places) if arguments.hold else None,
        "repeat": _repeat(arguments),
    }
    return {name: value for name, value in fields.items() if value is not None}


def _holds(texts: list[str], places: int) -> list[dict[str, Any] | None]:
    holds: list[dict[str, Any] | None] = [None] * places
    for text in texts:
        number, equals, seconds = text.partition("=")
        try:
            place, hold = int(number), {"seconds": float(seconds)} if equals else {"confirm": True}
        except ValueError as error:
            raise InvalidInput(f"--hold needs NUMBER or NUMBER=SECONDS, not {text!r}") from error
        if not 1 <= place <= places:
            raise InvalidInput(f"--hold {text}: the task has places 1 to {places}")
        holds[place - 1] = (holds[place - 1] or {}) | hold
    return holds


def _time(text: str) -> float:
    try:
        return datetime.fromisoformat(text).timestamp()
    except ValueError as error:
        raise InvalidInput(f"--start needs a time such as 2026-12-01T08:30, not {text!r}") from error


def _after(text: str) -> dict[str, str]:
    task, equals, end = text.partition("=")
    if equals and end not in ENDS:
        raise InvalidInput(f"--after needs TASK or TASK=END, where END is one of {', '.join(ENDS)}, not {text!r}")
    return {"task": task, "on": end} if equals else {"task": task}


def _repeat(arguments: argparse.Namespace) -> dict[str, Any] | None:
    known = {
        "at": arguments.repeat_at,
        "every": arguments.repeat_every,
        "days": arguments.days,
        "zone": arguments.zone,
        "count": arguments.times,
    }
    given = {name: value for name, value in known.items() if value is not None}
    if given and not given.keys() & {"at", "every"}:
        raise InvalidInput("--days, --zone and --times need --repeat-at or --repeat-every")
    return given or None
