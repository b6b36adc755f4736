"""Verbs of ``ppaas map`` for versions that wait for a review: ``reviews``, ``approve`` and ``refuse``."""

import argparse
from pathlib import Path
from typing import Any

from robots.cli.output import SHORT_HASH, show
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.cli.verbs.map_versions import ROLLED_BACK, draw
from robots.client.rest_paths import path_of

COLUMNS = ("number", "version", "state", "outdated", "author", "message", "occupied", "free", "known", "unknown")
ALL_COLUMNS = (*COLUMNS, "base", "created", "parts", "rectangles", "closed", "closed_by", "reason")


def configure(verbs: Any) -> None:
    """Add the verbs to ``ppaas map``."""
    reviews = verbs.add_parser("reviews", help="list the versions that wait for a review, or show one")
    approve = verbs.add_parser("approve", help="make a version that waits the current one")
    refuse = verbs.add_parser("refuse", help="refuse a version that waits")
    for verb in (reviews, approve, refuse):
        verb.add_argument("id")
        verb.add_argument("number", type=int, nargs="?", help="number of the review (the only one that waits)")
        add_session_arguments(verb)
    add_limit_argument(reviews)
    reviews.add_argument("--plot", type=Path, metavar="FILE.png", help="draw the changes of a version that waits")
    approve.add_argument("--why", default="", help="reason, stored with the review")
    approve.add_argument(
        "--force", action="store_true", help="also if another version than its base is current; give --why"
    )
    refuse.add_argument("--why", required=True, help="reason, stored with the review")


async def reviews(arguments: argparse.Namespace) -> None:
    """List the reviews of a map; or show one and draw its changes."""
    client = logged_in(arguments)
    if arguments.number is None and arguments.plot is None:
        found = await client.items(path_of("maps", arguments.id, "reviews"), arguments.limit)
        show(found, COLUMNS, as_json=arguments.json, if_none="no version of this map waits for a review")
        return
    review = await client.get(path_of("maps", arguments.id, "reviews", str(await _number(arguments))))
    if arguments.plot is not None:
        await draw(client, arguments.id, {"old": review["base"], "new": review["version"]}, arguments.plot)
    show(review if arguments.json else _for_people(review), ALL_COLUMNS, as_json=arguments.json)


async def approve(arguments: argparse.Namespace) -> None:
    """Make a version that waits the current one."""
    body = {"why": arguments.why, "force": arguments.force}
    show(await _decide(arguments, "approve", body), ROLLED_BACK, as_json=arguments.json)


async def refuse(arguments: argparse.Namespace) -> None:
    """Refuse a version that waits."""
    show(await _decide(arguments, "refuse", {"why": arguments.why}), COLUMNS, as_json=arguments.json)


async def _decide(arguments: argparse.Namespace, verb: str, body: dict[str, Any]) -> Any:
    number = await _number(arguments)
    return await logged_in(arguments).post(path_of("maps", arguments.id, "reviews", str(number), verb), body)


async def _number(arguments: argparse.Namespace) -> int:
    """Return the number given, or the number of the only review that waits.

    Raises
    ------
    InvalidInput
        No number is given, and not exactly one version waits.
    """
    if arguments.number is not None:
        number: int = arguments.number
        return number
    from ppaas.errors import InvalidInput  # noqa: PLC0415 - ``ppaas --help`` loads this module

    listed = await logged_in(arguments).items(path_of("maps", arguments.id, "reviews"))
    waiting = [one["number"] for one in listed if one["state"] == "waiting"]
    if len(waiting) != 1:
        numbers = ", ".join(map(str, waiting)) or "none"
        raise InvalidInput(f"give the number of the review; those that wait: {numbers}")
    return int(waiting[0])


def _for_people(review: dict[str, Any]) -> dict[str, Any]:
    boxes = [f"{one['width']}×{one['height']} at ({one['column']}, {one['row']})" for one in review["rectangles"]]
    return review | {"rectangles": ", ".join(boxes), "base": review["base"][:SHORT_HASH]}
