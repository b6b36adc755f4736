"""Verbs of ``ppaas map`` for versions: list, differences, roll-back, deletion, and reviews with their outcome."""

import argparse
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import NotFound
from robots.cli.output import SHORT_HASH, show
from robots.cli.session import add_limit_argument, add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient


WHOLE = 64
"""Length of a version's hash; an unambiguous prefix names the version too."""

VERSIONS = ("version", "created", "author", "message", "restored", "parts", "present")
DIFFERENCE = ("old", "new", "changed", "rectangle", "corners", "aligned", "octomap", "zones")
ROLLED_BACK = ("id", "owner", "version", "created", "author", "message", "restored")


async def list_versions(arguments: argparse.Namespace) -> None:
    """List the versions of a map with author, time and message."""
    found = await logged_in(arguments).items(path_of("maps", arguments.id, "versions"), arguments.limit)
    show(found, VERSIONS, as_json=arguments.json)


async def diff(arguments: argparse.Namespace) -> None:
    """Show the difference between two versions, and draw it."""
    client = logged_in(arguments)
    old = await whole_version(client, arguments.id, arguments.old)
    new = await whole_version(client, arguments.id, arguments.new)
    if new is None:
        new = (await client.get(path_of("maps", arguments.id)))["version"]
    found = await client.get(f"{path_of('maps', arguments.id, 'difference')}?old={old}&new={new}")
    if arguments.plot is not None:
        await draw(client, arguments.id, found, arguments.plot)
    show(found if arguments.json else _for_people(found), DIFFERENCE, as_json=arguments.json)


async def roll_back(arguments: argparse.Namespace) -> None:
    """Make an earlier version the current one."""
    client = logged_in(arguments)
    version = await whole_version(client, arguments.id, arguments.version)
    restored = await client.roll_back_map(arguments.id, version or "", arguments.message or "")
    show(restored, ROLLED_BACK, as_json=arguments.json)


async def delete_version(arguments: argparse.Namespace) -> None:
    """Delete a version."""
    client = logged_in(arguments)
    version = await whole_version(client, arguments.id, arguments.version)
    await client.delete(path_of("maps", arguments.id, "versions", version or ""))


async def whole_version(client: "RestClient", map_id: str, prefix: str | None) -> str | None:
    """Return the version that a prefix of its hash names; None if the prefix is None.

    Raises
    ------
    NotFound
        No version, or more than one, has this prefix.
    """
    if prefix is None or len(prefix) >= WHOLE:
        return prefix
    listed: set[str] = {one["version"] for one in await client.items(path_of("maps", map_id, "versions"))}
    found = [version for version in listed if version.startswith(prefix)]
    if len(found) != 1:
        raise NotFound(f"version of map {map_id!r}:", prefix, sorted(version[:SHORT_HASH] for version in listed))
    return found[0]


def _for_people(found: dict[str, Any]) -> dict[str, Any]:
    cells, corners = found["rectangle"], found["corners"]
    shown = {side: found[side][:SHORT_HASH] for side in ("old", "new")}
    if cells is not None:
        shown["rectangle"] = f"{cells['width']}×{cells['height']} at ({cells['column']}, {cells['row']})"
        shown["corners"] = " ".join(f"({x:.2f}, {y:.2f})" for x, y in corners) + " m"
    return found | shown


async def draw(client: "RestClient", map_id: str, found: dict[str, Any], picture: Path) -> None:
    """Draw the difference of the versions ``old`` and ``new`` of a map as a PNG file."""
    from robots.pictures.map_change import write_change  # noqa: PLC0415 - pictures and maps need more than the base install
    from robots.pictures.path import check_picture  # noqa: PLC0415

    check_picture(picture)
    with tempfile.TemporaryDirectory(prefix="ppaas-diff-") as folder:
        sides = []
        for side in ("old", "new"):
            image = Path(folder) / side
            path = ("maps", map_id, "versions", found[side])
            await client.fetch_to(path_of(*path, "image"), image)
            sides.append((await client.fetch(path_of(*path, "yaml")), image))
        write_change(picture, *sides)


# -- verbs of ``ppaas map`` for versions that wait for a review: ``reviews``, ``approve`` and ``refuse`` ---------------

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
    show(review if arguments.json else _review_for_people(review), ALL_COLUMNS, as_json=arguments.json)


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


def _review_for_people(review: dict[str, Any]) -> dict[str, Any]:
    boxes = [f"{one['width']}×{one['height']} at ({one['column']}, {one['row']})" for one in review["rectangles"]]
    return review | {"rectangles": ", ".join(boxes), "base": review["base"][:SHORT_HASH]}
