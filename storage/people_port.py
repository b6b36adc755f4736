"""Port of people: settings of the people of maps, and how many people were seen, by the rules of ``storage.ports``."""

from collections.abc import Iterable
from typing import Protocol

from storage.people_records import BEFORE_ALL, MapPeople, PeopleCount


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
