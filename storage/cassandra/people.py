"""Settings and counts of people in Cassandra."""

from collections.abc import Iterable, Sequence

from storage.cassandra.connection.session import CassandraSession, Write
from storage.cassandra.sorted_rows import generation_of
from storage.encoding import decode, decode_readable, encode
from storage.names import check_name
from storage.people import (
    BEFORE_ALL,
    MapPeople,
    PeopleCount,
    changed_meanwhile,
    check_count,
    check_people,
)

AT_ONCE = 64
"""Counts that are written in one conditional batch."""

_KEY = "map = ? AND user = ? AND generation = ?"

Key = tuple[str, str, int]
"""Map, user, the user's generation (``storage.cassandra.connection.cluster``)."""


class CassandraPeople:
    """A ``PeopleStore`` in Cassandra.

    The counts of a user on a map are a partition. It is found by the row of the settings, so counts are written only if
    that row exists, and removed before it.
    """

    _session: CassandraSession

    def put_people_settings(self, record: MapPeople, *, instead_of: MapPeople | None = None) -> None:
        """Store the settings of a user on a map; ``Conflict`` if the stored record is not ``instead_of``."""
        key, data = self._people_key(*record.key), encode(record)
        while True:
            before = self._people_record(key)
            if instead_of is not None and _record(before, key) != instead_of:
                raise changed_meanwhile(record.map)
            if self._session.write_if(f"UPDATE people SET record = ? WHERE {_KEY} IF record = ?", data, *key, before):
                return

    def map_people(self, user: str, map_id: str) -> MapPeople:
        """Return the settings of a user on a map; the defaults if none are stored."""
        key = self._people_key(user, map_id)
        return _record(self._people_record(key), key)

    def people_of_map(self, map_id: str) -> list[MapPeople]:
        """Return the settings of all users on a map, sorted by user."""
        query = "SELECT user, generation, record FROM people WHERE map = ?"
        rows = list(self._session.rows(query, check_name("map", map_id)))
        mine = [row for row in rows if row.record and row.generation == generation_of(self._session, row.user)]
        return decode_readable(((row.record, f"people/{map_id}/{row.user}") for row in mine), MapPeople)

    def people_maps(self) -> list[str]:
        """Return the ids of the maps that have settings, sorted."""
        return self._session.partitions("people", "map")

    def add_people_counts(self, rows: Iterable[PeopleCount]) -> None:
        """Store counts; of two counts of the same user, map, zone and hour, the larger one stays."""
        groups: dict[tuple[str, str], dict[tuple[int, str], int]] = {}
        for row in map(check_count, rows):
            mine = groups.setdefault((row.user, row.map), {})
            mine[row.hour, row.zone] = max(row.people, mine.get((row.hour, row.zone), 0))
        for people, counts in groups.items():
            key = self._people_key(*people)
            if self._people_record(key) is not None:
                rows_in_order = sorted(counts.items())
                for at in range(0, len(rows_in_order), AT_ONCE):
                    self._add_counts(key, rows_in_order[at : at + AT_ONCE])

    def people_counts(
        self, user: str, map_id: str, *, after: tuple[int, str] = BEFORE_ALL, limit: int | None = None
    ) -> list[PeopleCount]:
        """Return the counts of a user on a map, by hour and zone, which are the key."""
        query = f"SELECT hour, zone, people FROM people_counts WHERE {_KEY} AND (hour, zone) > (?, ?)"
        key = self._people_key(user, map_id)
        rows = self._session.rows_up_to(limit, query, *key, *after)
        return [PeopleCount(user, map_id, row.hour, row.zone, row.people) for row in rows]

    def remove_people_counts(self, user: str, map_id: str, *, before: int | None = None) -> None:
        """Remove the counts of the hours that begin before a time [s since the epoch]; all by default."""
        key = self._people_key(user, map_id)
        if before is None:
            self._session.write(f"DELETE FROM people_counts WHERE {_KEY}", *key)
        else:
            self._session.write(f"DELETE FROM people_counts WHERE {_KEY} AND hour < ?", *key, before)

    def remove_people(self, map_id: str) -> None:
        """Remove the settings and counts of all users on a map, if there are any."""
        query = "SELECT user, generation FROM people WHERE map = ?"
        for row in list(self._session.rows(query, check_name("map", map_id))):
            self._drop_people((map_id, row.user, row.generation))

    # -- internals -----------------------------------------------------------------------------------------------------

    def _add_counts(self, key: Key, counts: Sequence[tuple[tuple[int, str], int]]) -> None:
        while writes := self._larger(key, counts):
            if self._session.write_batch_if(writes):
                return  # otherwise another writer changed a row first

    def _larger(self, key: Key, counts: Sequence[tuple[tuple[int, str], int]]) -> list[Write]:
        """Return conditional writes of the counts that are larger than the stored ones."""
        write = f"UPDATE people_counts SET people = ? WHERE {_KEY} AND hour = ? AND zone = ? IF people = ?"
        query = f"SELECT hour, zone, people FROM people_counts WHERE {_KEY} AND hour >= ? AND hour <= ?"
        rows = self._session.rows(query, *key, counts[0][0][0], counts[-1][0][0])
        kept = {(row.hour, row.zone): row.people for row in rows}
        return [
            (write, (people, *key, *place, kept.get(place)))
            for place, people in counts
            if place not in kept or kept[place] < people
        ]

    def _sweep_people(self, user: str, generation: int) -> None:
        for map_id in self.people_maps():
            if self._people_record((map_id, user, generation)) is not None:
                self._drop_people((map_id, user, generation))

    def _drop_people(self, key: Key) -> None:
        self._session.write(f"DELETE FROM people_counts WHERE {_KEY}", *key)
        self._session.write(f"DELETE FROM people WHERE {_KEY}", *key)

    def _people_key(self, user: str, map_id: str) -> Key:
        check_people(user, map_id)
        return map_id, user, generation_of(self._session, user)

    def _people_record(self, key: Key) -> bytes | None:
        row = self._session.row(f"SELECT record FROM people WHERE {_KEY}", *key)
        return None if row is None else row.record


def _record(stored: bytes | None, key: Key) -> MapPeople:
    return MapPeople(key[1], key[0]) if stored is None else decode(stored, MapPeople, f"people/{key[0]}/{key[1]}")
