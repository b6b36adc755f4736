"""Floors at the command line: the building that a map is a floor of, and places such as ``L2:10,8`` or ``L2:desk``."""

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from ppaas.errors import InvalidInput
from robots.cli.tasks.places import places_of, stations_of
from robots.client.cloud_url import path_of

if TYPE_CHECKING:
    from robots.client.rest import RestClient

Stations = dict[str, tuple[float, ...]]


class MapFloors(NamedTuple):
    """Floors of the building of a map.

    Parameters
    ----------
    building : str
        Address of the building.
    home : str
        Floor of the map.
    maps : mapping of str to str
        Maps of all floors.
    """

    building: str
    home: str
    maps: Mapping[str, str]

    def map_on(self, floor: str) -> str:
        """Return the map of a floor; ``InvalidInput`` with the names of all if it does not exist."""
        if floor not in self.maps:
            raise InvalidInput(f"building {self.building} has no floor {floor!r}; it has {', '.join(self.maps)}")
        return self.maps[floor]


async def floors_of(client: "RestClient", map_id: str) -> MapFloors | None:
    """Return the floors of the building that a map is a floor of, the caller's own first; None if there is none."""
    me = (await client.get(path_of("users", "me")))["id"]
    found = [each for each in await client.items(path_of("buildings")) if map_id in each["maps"]]
    if not found:
        return None
    building = min(found, key=lambda each: (each["owner"] != me, each["owner"], each["id"]))
    address = building["id"] if building["owner"] == me else f"{building['owner']}:{building['id']}"
    maps = dict(zip(building["floors"], building["maps"], strict=True))
    home = next(floor for floor, name in maps.items() if name == map_id)
    return MapFloors(address, home, maps)


async def needed_floors(client: "RestClient", map_id: str, named: Collection[str]) -> MapFloors | None:
    """Return the floors of the building of a map if floors are named; ``InvalidInput`` if it has not all of them."""
    if not named:
        return None
    floors = await floors_of(client, map_id)
    if floors is None:
        raise InvalidInput(f"the map {map_id} is no floor of a building; see ppaas building")
    for floor in named:
        floors.map_on(floor)
    return floors


async def stations_on(client: "RestClient", floors: MapFloors | None, named: Collection[str]) -> dict[str, Stations]:
    """Return the stations of the floors that are named."""
    return {} if floors is None else {name: await stations_of(client, floors.map_on(name)) for name in named}


async def places_on_floors(
    client: "RestClient", map_id: str, given: Sequence[Sequence[str]]
) -> tuple[list[list[float]], list[str | None] | None]:
    """Return places and their floors: numbers or stations, with ``FLOOR:`` before them if they are on another floor.

    The floors are None if no place has one, as on a map that is of no building.

    Raises
    ------
    InvalidInput
        A floor or a station does not exist.
    """
    texts = [" ".join(words) for words in given]
    floors = await floors_of(client, map_id) if any(":" in text for text in texts) else None
    places: list[list[float]] = []
    found: list[str | None] = []
    for words, text in zip(given, texts, strict=True):
        floor, colon, rest = text.partition(":")
        is_there = floors is not None and bool(colon) and floor in floors.maps
        on = floors.maps[floor] if floors is not None and is_there else map_id
        places += await places_of(client, on, [_words(rest)] if is_there else [words])
        found.append(floor if is_there else None)
    return places, found if any(found) else None


def _words(text: str) -> list[str]:
    """Return the words of a place behind its floor: its numbers, or the name of a station as one word."""
    parts = text.replace(",", " ").split()
    try:
        return [str(float(part)) for part in parts]
    except ValueError:
        return [text.strip()]
