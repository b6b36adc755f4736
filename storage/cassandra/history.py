"""Planning history in Cassandra."""

from collections.abc import Iterable, Sequence

from ppaas.plans.history import LinkHistory, PlannerHistory
from storage.cassandra.connection.session import CassandraSession, Write
from storage.encoding import decode_readable, encode
from storage.history_checks import check_history, check_link
from storage.names import check_name

_ROW = "map = ? AND version = ? AND planner = ? AND bucket = ?"


class CassandraHistory:
    """A ``HistoryStore`` in Cassandra.

    Sums are read, increased and written by compare-and-set, so concurrent writers lose nothing and count nothing twice.
    (Cassandra's counters guarantee neither after a timeout.)
    """

    _session: CassandraSession

    def add_history(self, rows: Iterable[PlannerHistory]) -> None:
        """Add each row to the sums of its key; for each map all rows or none."""
        by_map: dict[str, dict[tuple[str, str, str, int], PlannerHistory]] = {}
        for row in map(check_history, rows):
            mine = by_map.setdefault(row.map, {})
            mine[row.key] = mine[row.key].plus(row) if row.key in mine else row
        for mine in by_map.values():
            while not self._session.write_batch_if(self._sums(list(mine.values()))):
                continue  # another writer changed a row first

    def history(self, map_id: str, version: str | None = None) -> list[PlannerHistory]:
        """Return the rows of a map, or of one of its versions, sorted by key."""
        check_name("map", map_id)
        query, values = "SELECT version, planner, bucket, record FROM history WHERE map = ?", [map_id]
        if version is not None:
            query, values = f"{query} AND version = ?", [map_id, version]
        rows = self._session.rows(query, *values)
        placed = ((row.record, _place((map_id, row.version, row.planner, row.bucket))) for row in rows)
        return decode_readable(placed, PlannerHistory)

    def history_maps(self) -> list[str]:
        """Return the ids of the maps that have rows, sorted."""
        return self._session.partitions("history", "map")

    def remove_history(self, map_id: str) -> None:
        """Remove the rows of a map, if it has any."""
        self._session.write("DELETE FROM history WHERE map = ?", check_name("map", map_id))

    def put_link(self, row: LinkHistory) -> None:
        """Store the measurements of a link in place of the previous ones."""
        insert = "INSERT INTO links (shard, link, record) VALUES (0, ?, ?)"
        self._session.write(insert, check_link(row).link, encode(row))

    def links(self) -> list[LinkHistory]:
        """Return the measurements of all links, sorted by name."""
        rows = self._session.rows("SELECT link, record FROM links WHERE shard = 0")
        return decode_readable(((row.record, f"links/{row.link}") for row in rows), LinkHistory)

    def _sums(self, rows: Sequence[PlannerHistory]) -> list[Write]:
        """Return conditional writes that add rows of one map to the stored sums, if these have not changed."""
        write = f"UPDATE history SET record = ? WHERE {_ROW} IF record = ?"
        writes: list[Write] = []
        for row in rows:
            kept = self._session.row(f"SELECT record FROM history WHERE {_ROW}", *row.key)
            before = None if kept is None else kept.record
            # Sums that are damaged begin again.
            known = decode_readable([] if before is None else [(before, _place(row.key))], PlannerHistory)
            after = known[0].plus(row) if known else row
            writes.append((write, (encode(after), *row.key, before)))
        return writes


def _place(key: tuple[str, str, str, int]) -> str:
    return f"history/{'/'.join(map(str, key))}"
