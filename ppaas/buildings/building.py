"""Record of a building: its floors, and what is known of its lifts, doors and ways beside their places on maps.

The places are zones of the maps of the floors (``ppaas.zones.zone``): a zone of the kind ``lift``, ``door`` or
``passage`` names what it belongs to, and moves with the version of its map. The record has what no map shows: heights,
times, and the devices that open doors and send lifts.
"""

import math
from collections import Counter
from collections.abc import Iterable
from typing import Annotated, Literal

import msgspec
from msgspec import Meta

from ppaas.decoding import from_json
from ppaas.errors import InvalidBuilding

MOST_FLOORS, MOST_LIFTS, MOST_DOORS, MOST_WAYS = 200, 100, 2000, 200
"""Largest numbers of floors, lifts, doors and ways of a building."""

HIGHEST, FARTHEST = 2000.0, 100_000.0
"""Limits of an elevation and of the coordinates of an anchor [m]."""

LONGEST_ID, LONGEST_DEVICE = 64, 512

Id = Annotated[str, Meta(min_length=1, max_length=LONGEST_ID, pattern=r"^[^\s/][^/\x00-\x1f]*$")]
"""Name of a floor, a lift, a door or a way."""

Seconds = Annotated[float, Meta(ge=0.0, le=3600.0)]

Device = Annotated[str, Meta(max_length=LONGEST_DEVICE)]
"""URL of the device that a plug-in drives, such as ``sim:`` or ``http://…``; empty: nothing can be asked for it."""

Anchor = tuple[float, float, float]
"""Pose of the frame of a map in the frame of the building: x, y [m], yaw [rad]."""


class BuildingPart(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True, kw_only=True):
    """Base of the parts of a building; unknown members are refused, so that a misspelt one is not lost."""


class Floor(BuildingPart, frozen=True):
    """Floor of a building: a map, and where it is.

    Parameters
    ----------
    name : str
        Name that no other floor of the building has, such as ``L1``.
    map : str
        Id of its map. Its current version is the floor.
    elevation : float
        Height above the floor at 0 [m].
    anchor : Anchor
        Where its map is in the frame of the building.
    """

    name: Id
    map: Annotated[str, Meta(min_length=1, max_length=256)]
    elevation: float = 0.0
    anchor: Anchor = (0.0, 0.0, 0.0)


class LiftSettings(BuildingPart, frozen=True):
    """What is known of a lift; all of it has usual values.

    Parameters
    ----------
    lift : str
        Id, by which zones of the kind ``lift`` and ``door`` name it.
    robots : int
        Largest number of robots in its car.
    speed : float
        Usual speed of the car [m/s].
    wait, doors : float
        Mean time until a car that is called stands open, and time in which its doors open or close [s].
    device : str
        URL of what sends the car and holds it open.
    """

    lift: Id
    robots: Annotated[int, Meta(ge=1, le=100)] = 1
    speed: Annotated[float, Meta(gt=0.0, le=20.0)] = 1.0
    wait: Seconds = 20.0
    doors: Seconds = 3.0
    device: Device = ""


class DoorSettings(BuildingPart, frozen=True):
    """What is known of a door.

    Parameters
    ----------
    floor, door : str
        Floor, and name of the zone of the kind ``door``.
    opens : float
        Time in which it opens [s].
    device : str
        URL of what opens it; a door without a device is open to robots.
    """

    floor: Id
    door: Id
    opens: Seconds = 3.0
    device: Device = ""


class WaySettings(BuildingPart, frozen=True):
    """Stairs, a ramp or a bridge between two floors, whose ends are zones of the kind ``passage``.

    Parameters
    ----------
    way : str
        Id, by which the zones name it.
    kind : {"stairs", "ramp", "bridge"}
    length : float, optional
        Length [m]; by default the distance between its ends in space.
    labels : dict of str to str
        Labels that a robot must have to take it.
    one_way : str
        Floor from which it may be entered; both if empty.
    """

    way: Id
    kind: Literal["stairs", "ramp", "bridge"] = "ramp"
    length: Annotated[float, Meta(gt=0.0, le=10_000.0)] | None = None
    labels: dict[str, str] = {}
    one_way: str = ""


class Building(BuildingPart, frozen=True):
    """Building.

    Parameters
    ----------
    floors : tuple of Floor
        From any floor to any other, in any order.
    lifts, doors, ways : tuple
        Settings of lifts, doors and ways; those that are not named have the usual values.

    Raises
    ------
    InvalidBuilding
        Two parts have one name, a floor is named that does not exist, a number is not valid, or there are too many.
    """

    floors: Annotated[tuple[Floor, ...], Meta(min_length=1)]
    lifts: tuple[LiftSettings, ...] = ()
    doors: tuple[DoorSettings, ...] = ()
    ways: tuple[WaySettings, ...] = ()

    def __post_init__(self) -> None:
        """Check what types do not."""
        for parts, most, what in (
            (self.floors, MOST_FLOORS, "floors"),
            (self.lifts, MOST_LIFTS, "lifts"),
            (self.doors, MOST_DOORS, "doors"),
            (self.ways, MOST_WAYS, "ways"),
        ):
            if len(parts) > most:
                raise InvalidBuilding(f"a building may have {most} {what}, not {len(parts)}")
        _check_unique((floor.name for floor in self.floors), "floors have the name {!r}: rename one of them")
        _check_unique((floor.map for floor in self.floors), "floors have the map {!r}: each floor has a separate one")
        _check_unique((lift.lift for lift in self.lifts), "lifts have the id {!r}: rename one of them")
        _check_unique((way.way for way in self.ways), "ways have the id {!r}: rename one of them")
        _check_unique(
            (f"{door.floor}/{door.door}" for door in self.doors), "settings are of the door {!r}: remove one of them"
        )
        for floor in self.floors:
            _check_floor(floor)
        for door in self.doors:
            self.floor(door.floor)
        for way in self.ways:
            if way.one_way:
                self.floor(way.one_way)

    def floor(self, name: str) -> Floor:
        """Return a floor; ``InvalidBuilding`` with the names of all if it does not exist."""
        found = next((floor for floor in self.floors if floor.name == name), None)
        if found is None:
            raise InvalidBuilding(
                f"there is no floor {name!r}; the floors are {', '.join(each.name for each in self.floors)}"
            )
        return found

    def floor_of_map(self, map_id: str) -> Floor | None:
        """Return the floor whose map this is; None if no floor has it."""
        return next((floor for floor in self.floors if floor.map == map_id), None)

    def lift(self, lift_id: str) -> LiftSettings:
        """Return the settings of a lift; the usual ones if none are given."""
        return next((each for each in self.lifts if each.lift == lift_id), LiftSettings(lift=lift_id))

    def way(self, way_id: str) -> WaySettings:
        """Return the settings of a way; the usual ones if none are given."""
        return next((each for each in self.ways if each.way == way_id), WaySettings(way=way_id))

    def door(self, floor: str, door: str) -> DoorSettings:
        """Return the settings of a door of a floor; the usual ones if none are given."""
        given = (each for each in self.doors if (each.floor, each.door) == (floor, door))
        return next(given, DoorSettings(floor=floor, door=door))


def building_of(text: str | bytes) -> Building:
    """Read the JSON of a building.

    Raises
    ------
    InvalidBuilding
        It is not JSON, or not a building; the text says where.
    """
    try:
        return from_json(text, Building)
    except msgspec.ValidationError as error:
        if isinstance(error.__cause__, InvalidBuilding):
            raise error.__cause__ from None
        raise InvalidBuilding(f"a building must have floors, each with a 'name' and a 'map': {error!s:.300}") from error
    except (msgspec.DecodeError, UnicodeError, RecursionError) as error:
        raise InvalidBuilding(f"a building is not valid JSON: {error!s:.300}") from error


def json_of(building: Building) -> bytes:
    """Return a building as JSON, the same bytes for the same building."""
    return msgspec.json.encode(building, order="deterministic")


def _check_unique(names: Iterable[str], text: str) -> None:
    name, number = max(Counter(names).items(), key=lambda item: item[1], default=("", 0))
    if number > 1:
        raise InvalidBuilding(f"{number} {text.format(name)}")


def _check_floor(floor: Floor) -> None:
    if not (math.isfinite(floor.elevation) and abs(floor.elevation) <= HIGHEST):
        raise InvalidBuilding(f"floor {floor.name!r}: its elevation must be up to {HIGHEST:g} m, not {floor.elevation}")
    if not all(math.isfinite(each) and abs(each) <= FARTHEST for each in floor.anchor):
        raise InvalidBuilding(
            f"floor {floor.name!r}: its anchor must be x, y [m] and yaw [rad] of its map in the building, "
            f"not {list(floor.anchor)}"
        )
