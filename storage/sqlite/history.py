"""Planning history in an SQLite file."""

from collections.abc import Iterable

from ppaas.plans.history import COUNTS, LinkHistory, PlannerHistory
from storage.encoding import decode_readable, encode
from storage.history_checks import check_history, check_link
from storage.names import check_name
from storage.sqlite.connections import SqliteConnections

_ADD = (
    f"INSERT INTO history VALUES ({', '.join('?' * len(PlannerHistory.__struct_fields__))}) "
    f"ON CONFLICT DO UPDATE SET {', '.join(f'{name} = {name} + excluded.{name}' for name in COUNTS)}"
)


class SqliteHistory:
    """A ``HistoryStore`` in an SQLite file.

    Parameters
    ----------
    connections : SqliteConnections
        Connections to the file.
    """

    def __init__(self, connections: SqliteConnections) -> None:
        self._history_connections = connections

    def add_history(self, rows: Iterable[PlannerHistory]) -> None:
        """Add each row to the sums of its key, all or none."""
        checked = [(*row.key, *row.counts()) for row in map(check_history, rows)]
        with self._history_connections.writing() as connection:
            connection.executemany(_ADD, checked)

    def history(self, map_id: str, version: str | None = None) -> list[PlannerHistory]:
        """Return the rows of a map, or of one of its versions, sorted by key."""
        check_name("map", map_id)
        query = "SELECT * FROM history WHERE map = ?1 AND (?2 IS NULL OR version = ?2) ORDER BY 1, 2, 3, 4"
        with self._history_connections.reading() as connection:
            return [PlannerHistory(*row) for row in connection.execute(query, (map_id, version))]

    def history_maps(self) -> list[str]:
        """Return the ids of the maps that have rows, sorted."""
        with self._history_connections.reading() as connection:
            return [map_id for (map_id,) in connection.execute("SELECT DISTINCT map FROM history ORDER BY map")]

    def remove_history(self, map_id: str) -> None:
        """Remove the rows of a map, if it has any."""
        check_name("map", map_id)
        with self._history_connections.writing() as connection:
            connection.execute("DELETE FROM history WHERE map = ?", (map_id,))

    def put_link(self, row: LinkHistory) -> None:
        """Store the measurements of a link in place of the previous ones."""
        values = check_link(row).link, encode(row)
        with self._history_connections.writing() as connection:
            connection.execute("INSERT OR REPLACE INTO links VALUES (?, ?)", values)

    def links(self) -> list[LinkHistory]:
        """Return the measurements of all links, sorted by name."""
        with self._history_connections.reading() as connection:
            rows = connection.execute("SELECT record, 'links/' || link FROM links ORDER BY link").fetchall()
        return decode_readable(rows, LinkHistory)
