"""Settings and counts of people in memory."""

import threading
from collections.abc import Callable, Iterable

from storage.encoding import decode, encode
from storage.names import check_name
from storage.people import BEFORE_ALL, MapPeople, PeopleCount, changed_meanwhile, check_count, check_people


class MemoryPeople:
    """A ``PeopleStore`` of dictionaries. Settings are stored as bytes, because a caller may change their lists."""

    def __init__(self) -> None:
        self._people_lock = threading.Lock()
        self._people: dict[tuple[str, str], bytes] = {}
        self._people_counts: dict[tuple[str, str, int, str], PeopleCount] = {}

    def put_people_settings(self, record: MapPeople, *, instead_of: MapPeople | None = None) -> None:
        """Store the settings of a user on a map; ``Conflict`` if the stored record is not ``instead_of``."""
        check_people(*record.key)
        data = encode(record)
        with self._people_lock:
            if instead_of is not None and self._record(record.key) != instead_of:
                raise changed_meanwhile(record.map)
            self._people[record.key] = data

    def map_people(self, user: str, map_id: str) -> MapPeople:
        """Return the settings of a user on a map; the defaults if none are stored."""
        key = check_people(user, map_id)
        with self._people_lock:
            return self._record(key)

    def people_of_map(self, map_id: str) -> list[MapPeople]:
        """Return the settings of all users on a map, sorted by user."""
        check_name("map", map_id)
        with self._people_lock:
            records = [data for key, data in sorted(self._people.items()) if key[1] == map_id]
        return [decode(data, MapPeople) for data in records]

    def people_maps(self) -> list[str]:
        """Return the ids of the maps that have settings, sorted."""
        with self._people_lock:
            return sorted({map_id for _, map_id in self._people})

    def add_people_counts(self, rows: Iterable[PeopleCount]) -> None:
        """Store counts, all or none; of two counts of the same user, map, zone and hour, the larger one stays."""
        checked = [check_count(row) for row in rows]
        with self._people_lock:
            for row in checked:
                if (row.user, row.map) in self._people:
                    known = self._people_counts.get(row.key, row)
                    self._people_counts[row.key] = max(known, row)

    def people_counts(
        self, user: str, map_id: str, *, after: tuple[int, str] = BEFORE_ALL, limit: int | None = None
    ) -> list[PeopleCount]:
        """Return the counts of a user on a map, by hour and zone, which are the key."""
        key = check_people(user, map_id)
        with self._people_lock:
            rows = sorted(self._people_counts.values())
        return [row for row in rows if (row.user, row.map) == key and (row.hour, row.zone) > after][:limit]

    def remove_people_counts(self, user: str, map_id: str, *, before: int | None = None) -> None:
        """Remove the counts of the hours that begin before a time [s since the epoch]; all by default."""
        people = check_people(user, map_id)
        with self._people_lock:
            self._people_counts = {
                key: row
                for key, row in self._people_counts.items()
                if key[:2] != people or (before is not None and row.hour >= before)
            }

    def remove_people(self, map_id: str) -> None:
        """Remove the settings and counts of all users on a map, if there are any."""
        check_name("map", map_id)
        self._forget_people(lambda key: key[1] == map_id)

    def _forget_people(self, forgotten: Callable[[tuple[str, str]], bool]) -> None:
        """Remove the settings and counts of the users and maps for which a function returns true."""
        with self._people_lock:
            self._people = {key: data for key, data in self._people.items() if not forgotten(key)}
            self._people_counts = {key: row for key, row in self._people_counts.items() if not forgotten(key[:2])}

    def _record(self, key: tuple[str, str]) -> MapPeople:
        data = self._people.get(key)
        return MapPeople(*key) if data is None else decode(data, MapPeople)
