"""Publication of the files of a map, as ``ppaas map publish`` and the imports of maps do it."""

import argparse
from pathlib import Path
from typing import Any

from robots.cli.output import print_warnings, show
from robots.cli.session import logged_in
from robots.cli.verbs import map_versions
from robots.cli.verbs.map_versions import whole_version

_GRID = ("width", "height", "resolution", "origin")
COLUMNS = ("id", "owner", "version", *_GRID, "readers", "description", "traffic", "georeference")

NOBODY = "-"

Content = bytes | Path


def add_publication_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of a publication, without those of the session."""
    parser.add_argument("--id", help="id of the map (name of the file)")
    parser.add_argument(
        "--review", action="store_true", help="let the version wait until the owner approves or refuses it"
    )
    parser.add_argument("--if-match", metavar="VERSION", help="publish only if this is the current version")
    parser.add_argument("--message", help="reason, stored with the version")
    add_description_arguments(parser)


def add_description_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options that describe a map."""
    parser.add_argument(
        "--reader", action="append", help=f"another user who may use it; * for everybody, {NOBODY} for nobody"
    )
    parser.add_argument("--description", help="description of the map")


async def publish(
    arguments: argparse.Namespace,
    map_id: str,
    yaml: bytes | None,
    image: Content | None,
    **parts: Content | str | None,
) -> None:
    """Publish a map with the options of the command line, and show the answer.

    Parameters
    ----------
    arguments : Namespace
    map_id : str
    yaml, image : bytes or Path, optional
    **parts : bytes, Path or str, optional
        Further files and texts, as ``RestClient.upload_map`` takes them.
    """
    client = logged_in(arguments)
    readers = tuple("" if name == NOBODY else name for name in arguments.reader or ())
    texts: dict[str, Any] = {"description": arguments.description, "message": arguments.message}
    texts |= {"review": "true"} if arguments.review else {}
    expected = await whole_version(client, map_id, arguments.if_match)
    given: dict[str, Any] = {**parts, **texts}
    answer = await client.upload_map(map_id, yaml, image, readers, if_match=expected, **given)
    columns = map_versions.COLUMNS if arguments.review else COLUMNS
    show(answer, columns, as_json=arguments.json)
    if not arguments.json:
        print_warnings(answer)
