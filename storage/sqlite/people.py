"""Settings and counts of people in an SQLite file."""

import sqlite3
from collections.abc import Iterable

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
from storage.sqlite.connections import SqliteConnections

_PLACE = "'people/' || map || '/' || user"
_RECORD = f"SELECT record, {_PLACE} FROM people WHERE user = ? AND map = ?"

_ADD = """INSERT INTO people_counts SELECT user, map, ?, ?, ? FROM people WHERE user = ? AND map = ?
          ON CONFLICT DO UPDATE SET people = max(people, excluded.people)"""


class SqlitePeople:
    """A ``PeopleStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._people_connections = connections

    def put_people_settings(self, record: MapPeople, *, instead_of: MapPeople | None = None) -> None:
        """Store the settings of a user on a map; ``Conflict`` if the stored record is not ``instead_of``."""
        key, data = check_people(*record.key), encode(record)
        with self._people_connections.writing() as connection:
            if instead_of is not None and _record(connection, key) != instead_of:
                raise changed_meanwhile(record.map)
            connection.execute("INSERT OR REPLACE INTO people VALUES (?, ?, ?)", (*key, data))

    def map_people(self, user: str, map_id: str) -> MapPeople:
        """Return the settings of a user on a map; the defaults if none are stored."""
        key = check_people(user, map_id)
        with self._people_connections.reading() as connection:
            return _record(connection, key)

    def people_of_map(self, map_id: str) -> list[MapPeople]:
        """Return the settings of all users on a map, sorted by user."""
        check_name("map", map_id)
        query = f"SELECT record, {_PLACE} FROM people WHERE map = ? ORDER BY user"
        with self._people_connections.reading() as connection:
            rows = connection.execute(query, (map_id,)).fetchall()
        return decode_readable(rows, MapPeople)

    def people_maps(self) -> list[str]:
        """Return the ids of the maps that have settings, sorted."""
        with self._people_connections.reading() as connection:
            return [map_id for (map_id,) in connection.execute("SELECT DISTINCT map FROM people ORDER BY map")]

    def add_people_counts(self, rows: Iterable[PeopleCount]) -> None:
        """Store counts, all or none; of two counts of the same user, map, zone and hour, the larger one stays."""
        checked = [(row.hour, row.zone, row.people, row.user, row.map) for row in map(check_count, rows)]
        with self._people_connections.writing() as connection:
            connection.executemany(_ADD, checked)

    def people_counts(
        self, user: str, map_id: str, *, after: tuple[int, str] = BEFORE_ALL, limit: int | None = None
    ) -> list[PeopleCount]:
        """Return the counts of a user on a map, by hour and zone, which are the key."""
        query = """SELECT user, map, hour, zone, people FROM people_counts
                   WHERE user = ? AND map = ? AND (hour, zone) > (?, ?) ORDER BY hour, zone LIMIT ?"""
        values = (*check_people(user, map_id), *after, -1 if limit is None else limit)
        with self._people_connections.reading() as connection:
            return [PeopleCount(*row) for row in connection.execute(query, values)]

    def remove_people_counts(self, user: str, map_id: str, *, before: int | None = None) -> None:
        """Remove the counts of the hours that begin before a time [s since the epoch]; all by default."""
        remove = "DELETE FROM people_counts WHERE user = ?1 AND map = ?2 AND (?3 IS NULL OR hour < ?3)"
        with self._people_connections.writing() as connection:
            connection.execute(remove, (*check_people(user, map_id), before))

    def remove_people(self, map_id: str) -> None:
        """Remove the settings and counts of all users on a map, if there are any."""
        check_name("map", map_id)
        with self._people_connections.writing() as connection:
            for table in ("people", "people_counts"):
                connection.execute(f"DELETE FROM {table} WHERE map = ?", (map_id,))


def _record(connection: sqlite3.Connection, key: tuple[str, str]) -> MapPeople:
    row = connection.execute(_RECORD, key).fetchone()
    return MapPeople(*key) if row is None else decode(row[0], MapPeople, row[1])
