"""Verb ``ppaas map zones``: shows and draws the zones of a map, writes them to a file, replaces and removes them."""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.clock import epoch
from ppaas.errors import InvalidInput, InvalidZones, ZoneFault
from robots.cli.output import print_line, print_warnings, show
from robots.cli.output_files import write_file
from robots.cli.session import add_session_arguments, logged_in
from robots.cli.verbs.map_versions import whole_version
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient


def check_zones_picture(picture: Path | None) -> None:
    """Raise ``InvalidInput`` if a picture has another ending than ``.png``."""
    if picture is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - pictures need more than the base install

        check_picture(picture)


async def draw_zones(
    client: "RestClient", path: str, picture: Path | None, geojson: bytes, faults: Sequence[ZoneFault] = ()
) -> None:
    """Draw zones and their faults on a map as a PNG file, if one is named.

    Parameters
    ----------
    client : RestClient
    path : str
        Path of the map or of a version of it.
    picture : Path, optional
    geojson : bytes
    faults : sequence of ZoneFault
    """
    if picture is None:
        return
    # Pictures and maps need more than the base install.
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415
    from robots.pictures.map_pictures import write_zones  # noqa: PLC0415

    yaml, image = [await client.fetch(f"{path}/{part}") for part in ("yaml", "image")]
    write_zones(picture, load_map(yaml, image), geojson, faults)


COLUMNS = ("name", "kind", "detail", "times")
CHECKED = ("zones",)
PUBLISHED = ("id", "owner", "version", "created", "author", "message", "parts")

Zone = dict[str, Any]
"""Feature of GeoJSON."""


def configure(verbs: Any) -> None:
    """Add the parser of the verb."""
    zones = verbs.add_parser(
        "zones",
        help="show the zones of a map: keep-out, speed, one-way, no-stop and capacity; put or remove them",
        description="Zones are a file of each version of a map: --put and --remove publish a version.",
    )
    zones.add_argument("id")
    change = zones.add_mutually_exclusive_group()
    change.add_argument("--put", type=Path, metavar="FILE", help="publish the zones of a file of GeoJSON")
    change.add_argument("--remove", action="store_true", help="publish a version without zones")
    change.add_argument("--version", help="show those of a version, or a prefix of it (the current one)")
    zones.add_argument("--dry-run", action="store_true", help="with --put: check the zones, and publish nothing")
    zones.add_argument(
        "--picture", type=Path, metavar="FILE.png", help="draw the zones on the map, with a red cross at each fault"
    )
    zones.add_argument("--out", type=Path, metavar="FILE", help="write the zones to a file of GeoJSON")
    zones.add_argument(
        "--vda5050", action="store_true", help="with --put and --out: the file is a message zoneSet of VDA 5050 3.0"
    )
    zones.add_argument("--message", help="with --put and --remove: reason, stored with the version")
    zones.add_argument("--if-match", metavar="VERSION", help="with them: change only if this is the current version")
    add_session_arguments(zones)


async def zones(arguments: argparse.Namespace) -> None:
    """Put, remove, write or show the zones of a map."""
    changes = arguments.put is not None or arguments.remove
    if not changes and (arguments.message, arguments.if_match) != (None, None):
        raise InvalidInput("nothing to change; give --put FILE or --remove")
    if arguments.vda5050 and arguments.put is None and arguments.out is None:
        raise InvalidInput("--vda5050 is the format of a file; give --put FILE or --out FILE")
    if changes and arguments.out is not None:
        raise InvalidInput("--out writes the zones as they are; leave out --put and --remove")
    if arguments.dry_run and arguments.put is None:
        raise InvalidInput("--dry-run checks the zones of a file; give --put FILE")
    if arguments.picture is not None and (arguments.remove or arguments.out is not None):
        raise InvalidInput("--picture draws zones that are shown or put; leave out --remove and --out")
    check_zones_picture(arguments.picture)
    client = logged_in(arguments)
    if changes:
        await _change(client, arguments)
    elif arguments.out is not None:
        write_file(arguments.out, await _file(client, arguments))
    else:
        await _show(client, arguments)


async def _change(client: "RestClient", arguments: argparse.Namespace) -> None:
    expected = await whole_version(client, arguments.id, arguments.if_match)
    if arguments.remove:
        await client.remove_zones(arguments.id, arguments.message or "", expected)
        return
    content, path = read_zones(arguments.put), path_of("maps", arguments.id)
    if arguments.vda5050:
        from ppaas.wire.vda5050.map_zones import zones_of_vda5050  # noqa: PLC0415 - ``ppaas --help`` loads this module
        from ppaas.zones import reading  # noqa: PLC0415 - see above

        content = reading.geojson_of(zones_of_vda5050(content))
    try:
        if arguments.dry_run:
            answer = await client.check_zones(arguments.id, content)
        else:
            answer = await client.put_zones(arguments.id, content, arguments.message or "", expected)
    except InvalidZones as error:
        if error.faults:
            await draw_zones(client, path, arguments.picture, content, error.faults)
        raise
    await draw_zones(client, path, arguments.picture, content)
    show(answer, CHECKED if arguments.dry_run else PUBLISHED, as_json=arguments.json)
    if not arguments.json:
        print_warnings(answer)


async def _file(client: "RestClient", arguments: argparse.Namespace) -> bytes:
    content = await geojson_of(client, await _path(client, arguments))
    if not arguments.vda5050:
        return content
    from ppaas.wire.vda5050.map_zones import vda5050_of  # noqa: PLC0415 - ``ppaas --help`` loads this module
    from ppaas.zones import reading  # noqa: PLC0415 - see above

    given = await whole_version(client, arguments.id, arguments.version)
    version: str = given or (await client.get(path_of("maps", arguments.id)))["version"]
    return vda5050_of(reading.zones_of(content), arguments.id, f"zones-{version[:16]}", epoch())


async def geojson_of(client: "RestClient", path: str) -> bytes:
    """Download zones; return the content of their file, which does not say which are in force now."""
    found = await client.get(path)
    found.pop("in_force", None)
    return json.dumps(found, separators=(",", ":"), ensure_ascii=False).encode()


async def _path(client: "RestClient", arguments: argparse.Namespace) -> str:
    version = await whole_version(client, arguments.id, arguments.version)
    return path_of("maps", arguments.id, *(() if version is None else ("versions", version)), "zones")


async def _show(client: "RestClient", arguments: argparse.Namespace) -> None:
    path = await _path(client, arguments)
    found = await client.get(path)
    await draw_zones(client, path.removesuffix("/zones"), arguments.picture, json.dumps(found).encode())
    if arguments.json:
        print_line(json.dumps(found))
        return
    in_force = found.get("in_force")
    columns = COLUMNS if in_force is None else (*COLUMNS, "in_force")
    rows = [_row(zone["properties"], in_force or ()) for zone in found["features"]]
    show(rows, columns, as_json=False, if_none="no zones; add some: ppaas map zones MAP --put FILE.geojson")


def read_zones(file: Path) -> bytes:
    """Return the content of a file of zones, which the cloud checks; ``InvalidInput`` if it cannot be read."""
    try:
        return file.read_bytes()
    except OSError as error:
        raise InvalidInput(f"cannot read the zones: {error}") from error


def _row(rule: Zone, in_force: list[str] | tuple[str, ...]) -> Zone:
    return {
        "name": rule["name"],
        "kind": rule["kind"],
        "detail": _detail(rule),
        "times": "; ".join(map(_hours, rule.get("times", ()))) or "always",
        "in_force": rule["name"] in in_force,
    }


def _detail(rule: Zone) -> str | None:
    match rule:
        case {"max_speed": speed}:
            return f"{speed:g} m/s"
        case {"percent": percent}:
            return f"{percent:g} %"
        case {"robots": count}:
            return "1 robot" if count == 1 else f"{count} robots"
        case {"kind": "one_way"}:
            along = "along a line" if rule.get("direction") is None else f"{rule['direction']:.2f} rad"
            return f"{along}, strict" if rule.get("strict") else along
        case {"kind": "lane", "one_way": True}:
            return "one way"
        case _:
            return ", ".join(_words(rule)) or None


def _words(rule: Zone) -> list[str]:
    """Return what a place is for, and what it belongs to."""
    lift, charger = rule.get("lift"), "no charger" if rule.get("charges") is False else ""
    words = (f"of lift {lift}" if lift else "", rule.get("way", ""), rule.get("dock_type", ""), charger)
    return [*filter(None, words), *rule.get("uses", ())]


def _hours(hours: dict[str, Any]) -> str:
    days, begin, end = hours.get("days", ()), hours.get("from", "00:00"), hours.get("to", "24:00")
    parts = [" ".join(days), "" if (begin, end) == ("00:00", "24:00") else f"{begin}-{end}"]
    parts += [f"{key} {hours[key]}" for key in ("since", "until") if hours.get(key)]
    return " ".join(part for part in parts if part) or "always"
