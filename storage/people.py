"""People of a map: records of their settings and of counts by hour and zone, and the port of stores of them.

The port follows the rules of ``storage.ports``.
"""

from collections.abc import Iterable
from typing import Protocol

import msgspec

from ppaas.errors import Conflict, InvalidInput
from ppaas.people.settings import PeopleSettings
from storage.names import check_name

HOUR = 3600
"""Length of an hour [s]."""

BEFORE_ALL = (-1, "")
"""Hour and zone that precede all counts."""

LAST_HOUR = 1 << 40
"""Limit of the start of an hour [s since the epoch]: no store's 64-bit integers overflow."""

MOST_PEOPLE = 1 << 30
"""Limit of the number of people in an hour."""

LONGEST_ZONE = 64
"""Limit of the name of a zone [characters]."""


class MapPeople(msgspec.Struct, frozen=True):
    """Settings of the robots of a user on a map.

    Parameters
    ----------
    user, map : str
    settings : PeopleSettings
    counted_from : int
        Counts of hours that began before are not collected any more, because the user removed them [s since the epoch].
    """

    user: str
    map: str
    settings: PeopleSettings = PeopleSettings()
    counted_from: int = 0

    @property
    def key(self) -> tuple[str, str]:
        """User and map."""
        return self.user, self.map


class PeopleCount(msgspec.Struct, frozen=True, order=True):
    """Number of different people whom the robots of a user saw in a zone of a map in one hour.

    Parameters
    ----------
    user, map : str
    hour : int
        Start of the hour [s since the epoch].
    zone : str
        Name of the zone; empty for the whole map.
    people : int
        Number of different people.
    """

    user: str
    map: str
    hour: int
    zone: str
    people: int

    @property
    def key(self) -> tuple[str, str, int, str]:
        """User, map, hour and zone."""
        return self.user, self.map, self.hour, self.zone


def check_people(user: str, map_id: str) -> tuple[str, str]:
    """Return a user and a map; ``InvalidInput`` if a name is not valid."""
    return check_name("user", user), check_name("map", map_id)


def check_count(row: PeopleCount) -> PeopleCount:
    """Return a count; ``InvalidInput`` if a name is not valid, or a number is out of range."""
    check_people(row.user, row.map)
    if len(row.zone) > LONGEST_ZONE or not _is_unicode(row.zone):
        raise InvalidInput(
            f"zone {row.zone[:LONGEST_ZONE]!r} of map {row.map!r} must have up to {LONGEST_ZONE} letters"
        )
    if not 0 <= row.hour < LAST_HOUR or row.hour % HOUR:
        raise InvalidInput(f"count of map {row.map!r}: {row.hour} s is not the start of an hour")
    if not 0 <= row.people <= MOST_PEOPLE:
        raise InvalidInput(f"count of map {row.map!r}: {row.people} people are not between 0 and {MOST_PEOPLE}")
    return row


def _is_unicode(text: str) -> bool:
    return not any("\ud800" <= letter <= "\udfff" for letter in text)


def changed_meanwhile(map_id: str) -> Conflict:
    """Return the error of settings that another client changed first."""
    return Conflict(f"settings of the people of map {map_id!r} have been changed meanwhile: read them again and retry")


class PeopleStore(Protocol):
    """Settings of the robots of a user on a map, and numbers of people in an hour.

    Counts need stored settings: counts of other users and maps are not stored.
    """

    def put_people_settings(self, record: MapPeople, *, instead_of: MapPeople | None = None) -> None:
        """Store the settings of a user on a map, and from when people are counted.

        Raises
        ------
        Conflict
            ``instead_of`` is given and differs from what ``map_people`` returns: another client changed it first.
        """
        ...

    def map_people(self, user: str, map_id: str) -> MapPeople:
        """Return the settings of a user on a map; the defaults if none are stored."""
        ...

    def people_of_map(self, map_id: str) -> list[MapPeople]:
        """Return the settings of all users on a map, sorted by user."""
        ...

    def people_maps(self) -> list[str]:
        """Return the ids of the maps that have settings, sorted; the maps may have been removed."""
        ...

    def add_people_counts(self, rows: Iterable[PeopleCount]) -> None:
        """Store counts; of two counts of the same user, map, zone and hour, the larger one stays."""
        ...

    def people_counts(
        self, user: str, map_id: str, *, after: tuple[int, str] = BEFORE_ALL, limit: int | None = None
    ) -> list[PeopleCount]:
        """Return the counts of a user on a map, by hour and zone, which are the key."""
        ...

    def remove_people_counts(self, user: str, map_id: str, *, before: int | None = None) -> None:
        """Remove the counts of the hours that begin before a time [s since the epoch]; all by default."""
        ...

    def remove_people(self, map_id: str) -> None:
        """Remove the settings and counts of all users on a map, if there are any."""
        ...
