"""Places at the command line: numbers, or names of stations of a map."""

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING

from ppaas.errors import InvalidInput
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient


async def places_of(client: "RestClient", map_id: str, given: Sequence[Sequence[str]]) -> list[list[float]]:
    """Return places that are given as numbers or as names of stations of a map.

    Raises
    ------
    InvalidInput
        The map has no station of that name; the text has those that it has.
    """
    numbers = [_numbers(words) for words in given]
    if None not in numbers:
        return [place for place in numbers if place is not None]
    stations = await stations_of(client, map_id)
    return [
        place if place is not None else _station(stations, " ".join(words), map_id)
        for place, words in zip(numbers, given, strict=True)
    ]


async def stations_of(client: "RestClient", map_id: str) -> dict[str, tuple[float, ...]]:
    """Return the stations of a map by name: x, y [m] and, if it has one, yaw [rad]."""
    zones = await client.get(path_of("maps", map_id, "zones"))
    found: dict[str, tuple[float, ...]] = {}
    for zone in zones["features"]:
        if zone["properties"]["kind"] == "station":
            x, y = zone["geometry"]["coordinates"][:2]
            yaw = zone["properties"].get("yaw")
            found[zone["properties"]["name"]] = (x, y) if yaw is None else (x, y, yaw)
    return found


def _numbers(words: Sequence[str]) -> list[float] | None:
    try:
        return [float(word) for word in words]
    except ValueError:
        return None


def _station(stations: Mapping[str, tuple[float, ...]], name: str, map_id: str) -> list[float]:
    if name not in stations:
        near = get_close_matches(name, stations, 3, 0.4) or sorted(stations)[:10]
        known = f"; do you mean {', '.join(map(repr, near))}?" if near else ": it has none; see ppaas map import-graph"
        raise InvalidInput(f"the map {map_id} has no station {name!r}{known}")
    return list(stations[name])
