"""Buildings in an SQLite file."""

from sqlite3 import Connection

from storage.buildings.records import BuildingRecord, no_building
from storage.encoding import decode, decode_readable, encode
from storage.names import check_building_key, check_name
from storage.sqlite.connections import SqliteConnections

_PLACE = "'buildings/' || user || '/' || id"
_RECORD = f"SELECT record, {_PLACE} FROM buildings WHERE user = ? AND id = ?"


class SqliteBuildings:
    """A ``BuildingStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._building_connections = connections

    def put_building(self, record: BuildingRecord, *, instead_of: BuildingRecord | None = None) -> None:
        """Store a building; ``Conflict`` if the stored one is not ``instead_of``."""
        key, data = check_building_key(*record.key), encode(record)
        with self._building_connections.writing() as connection:
            if _building_or_none(connection, key) != instead_of:
                raise record.changed_meanwhile()
            connection.execute("INSERT OR REPLACE INTO buildings VALUES (?, ?, ?)", (*key, data))

    def building(self, user: str, building: str) -> BuildingRecord:
        """Return a building; ``NotFound`` if it does not exist."""
        key = check_building_key(user, building)
        with self._building_connections.reading() as connection:
            found = _building_or_none(connection, key)
        if found is None:
            raise no_building(building)
        return found

    def buildings(self, user: str, *, after: str = "", limit: int | None = None) -> list[BuildingRecord]:
        """Return the buildings of a user, sorted by id."""
        query = f"SELECT record, {_PLACE} FROM buildings WHERE user = ? AND id > ? ORDER BY id"
        with self._building_connections.reading() as connection:
            rows = connection.execute(query, (check_name("user", user), after))
            return decode_readable(rows, BuildingRecord, limit)

    def building_users(self) -> list[str]:
        """Return the users who have buildings, sorted."""
        with self._building_connections.reading() as connection:
            return [user for (user,) in connection.execute("SELECT DISTINCT user FROM buildings ORDER BY user")]

    def remove_building(self, user: str, building: str, *, instead_of: BuildingRecord | None = None) -> None:
        """Remove a building; ``Conflict`` if ``instead_of`` is given and differs from the stored one."""
        key = check_building_key(user, building)
        with self._building_connections.writing() as connection:
            if instead_of is not None and _building_or_none(connection, key) not in (None, instead_of):
                raise instead_of.changed_meanwhile()
            if not connection.execute("DELETE FROM buildings WHERE user = ? AND id = ?", key).rowcount:
                raise no_building(building)


def _building_or_none(connection: Connection, key: tuple[str, str]) -> BuildingRecord | None:
    row = connection.execute(_RECORD, key).fetchone()
    return None if row is None else decode(row[0], BuildingRecord, row[1])
