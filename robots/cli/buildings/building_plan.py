"""Verb ``ppaas building plan``: a route over the floors of a building, as a table or as a picture."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ppaas.errors import InvalidInput
from robots.cli.output import print_line, show
from robots.cli.session import add_session_arguments, logged_in
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

LEGS = ("kind", "name", "floor", "to_floor", "start", "goal", "length", "seconds", "plan_id")

Drives = Sequence[Sequence[Sequence[float]]]
"""Paths on a floor, each as rows that begin with x, y [m]."""


def configure(verbs: "argparse._SubParsersAction[Any]") -> None:
    """Add the verb."""
    verb = verbs.add_parser("plan", help="plan from a place on a floor to a place on any floor")
    verb.add_argument("id", help="id of the building; OWNER:ID for one of another user")
    for end in ("start", "goal"):
        verb.add_argument(end, metavar=f"{end.upper()}", help="FLOOR:X,Y[,YAW] in m and rad, such as L1:2,3.5")
    verb.add_argument("--alternatives", type=int, default=0, metavar="N", help="also N routes by other lifts and ways")
    verb.add_argument("--avoid", action="append", default=[], metavar="NAME", help="lift or way that is not taken")
    verb.add_argument(
        "--closed", action="append", default=[], metavar="FLOOR:DOOR", help="door that is closed, such as L1:kitchen"
    )
    verb.add_argument("--speed", type=float, default=0.5, metavar="M/S", help="mean speed of the robot [m/s] (0.5)")
    verb.add_argument("--stairs", action="store_true", help="the robot climbs stairs")
    verb.add_argument(
        "--label", action="append", default=[], metavar="NAME=VALUE", help="label of the robot, which a way asks for"
    )
    verb.add_argument("--picture", type=Path, metavar="FILE.png", help="draw the route on all floors side by side")
    add_session_arguments(verb)


async def plan_over_floors(arguments: argparse.Namespace) -> None:
    """Plan a route, print its legs, and draw it if a picture is named."""
    if arguments.picture is not None:
        from robots.pictures.path import check_picture  # noqa: PLC0415 - pictures need more than the base install

        check_picture(arguments.picture)
    start, goal = (_place(text) for text in (arguments.start, arguments.goal))
    labels = dict(_pair(text, "=", "a label must be NAME=VALUE") for text in arguments.label)
    closed = [_pair(text, ":", "a closed door must be FLOOR:DOOR") for text in arguments.closed]
    client = logged_in(arguments)
    found = await client.plan_in_building(
        arguments.id, start, goal, alternatives=arguments.alternatives, avoid=arguments.avoid,
        closed=[{"floor": floor, "door": door} for floor, door in closed],
        robot={"speed": arguments.speed, "labels": labels, "stairs": arguments.stairs},
    )  # fmt: skip
    if arguments.picture is not None:
        layout = await client.get(path_of("buildings", arguments.id, "layout"))
        await draw_floors(client, arguments.picture, layout["floors"], _drives(found))
    if arguments.json:
        show(found, LEGS, as_json=True)
        return
    show([_row(leg) for leg in found["legs"]], LEGS, as_json=False)
    print_line(_summary(found))
    for route in found["alternatives"]:
        print_line(f"or {_summary(route)}")


def _summary(route: dict[str, Any]) -> str:
    by = f" by {', '.join(route['takes'])}" if route["takes"] else ""
    return f"{route['seconds']:.1f} s, {route['length']:.1f} m{by}"


def _row(leg: dict[str, Any]) -> dict[str, Any]:
    places = {end: [round(each, 2) for each in leg[end]] for end in ("start", "goal")}
    times = {name: round(leg[name], 1) for name in ("length", "seconds")}
    return leg | places | times | {"name": leg["name"] or None, "plan_id": leg["plan_id"] or None}


def _drives(route: dict[str, Any]) -> dict[str, list[list[list[float]]]]:
    """Return the paths of a route by floor; a door is driven through in a straight line."""
    drives: dict[str, list[list[list[float]]]] = {}
    for leg in route["legs"]:
        if leg["kind"] in ("drive", "door"):
            drives.setdefault(leg["floor"], []).append(leg["poses"] or [leg["start"], leg["goal"]])
    return drives


def _place(text: str) -> dict[str, Any]:
    floor, numbers = _pair(text, ":", "a place must be FLOOR:X,Y or FLOOR:X,Y,YAW, such as L1:2,3.5")
    try:
        x, y, *yaw = map(float, numbers.split(","))
    except ValueError as error:
        raise InvalidInput(f"a place must be FLOOR:X,Y or FLOOR:X,Y,YAW, such as L1:2,3.5, not {text!r}") from error
    if len(yaw) > 1:
        raise InvalidInput(f"a place has x, y and a yaw, not more: {text!r}")
    return {"floor": floor, "x": x, "y": y, "yaw": yaw[0] if yaw else 0.0}


def _pair(text: str, mark: str, rule: str) -> tuple[str, str]:
    one, found, other = text.rpartition(mark) if mark == ":" else text.partition(mark)
    if not (one and found and other):
        raise InvalidInput(f"{rule}, not {text!r}")
    return one, other


async def draw_floors(
    client: "RestClient", picture: Path, floors: list[dict[str, Any]], paths: Mapping[str, Drives] | None = None
) -> None:
    """Draw floors side by side, with the paths that are driven on them."""
    # Pictures and maps need more than the base install.
    from ppaas.maps.formats.map_files import load_map  # noqa: PLC0415
    from robots.cli.verbs.map_zones import geojson_of  # noqa: PLC0415
    from robots.pictures.floors import FloorPicture, write_floors  # noqa: PLC0415

    driven = paths or {}
    drawn = []
    for floor in floors:
        path, name = path_of("maps", floor["map"]), floor["name"]
        grid = load_map(await client.fetch(f"{path}/yaml"), await client.fetch(f"{path}/image"))
        zones = await geojson_of(client, f"{path}/zones")
        drawn.append(FloorPicture(name, grid, zones, driven.get(name, ())))
    write_floors(picture, drawn)
