"""Removal of rows from sorted partitions, so that deleted rows do not pile up.

Cassandra keeps a deleted row as a *tombstone* for ``gc_grace_seconds``, and refuses a query that meets 100,000 of them.
Rows that come and go one by one would leave as many within days. So a removal deletes the whole gap between the rows
beside the removed one. Such a range covers the ranges of earlier removals in the gap, which Cassandra then skips: a
partition has at most one range more than it has rows.

A range is deleted with the time at which the removed row was written last, so rows that are added meanwhile stay. This
is exact where all writes are conditional: Cassandra orders the writes of a partition, and the rows beside are read
after the last one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from storage.cassandra.connection.session import CassandraSession, Write

BESIDE = 4
"""Rows that are read at once to find one that was not removed."""


@dataclass(frozen=True, slots=True)
class SortedRows:
    """Rows of a partition, or of a part of it, sorted by their last clustering column.

    Parameters
    ----------
    table : str
    group : str
        Condition that the rows have in common.
    column : str
        The last clustering column.
    backwards : str
        ``ORDER BY`` of all clustering columns, backwards.
    record : str, optional
        Column that is empty in rows that were marked as removed and not deleted yet.
    """

    table: str
    group: str
    column: str
    backwards: str
    record: str = ""

    def deletion(self, session: CassandraSession, group: Sequence[Any], place: Any, written: int) -> Write:
        """Return the deletion of a row with the gap around it.

        Parameters
        ----------
        session : CassandraSession
        group : sequence
            Values of the condition.
        place
            Value of the last clustering column.
        written : int
            Time of the last write of the row [µs since the epoch].
        """
        bounds, values = "", list[Any]()
        for sign, order in (("<", f" ORDER BY {self.backwards}"), (">", "")):
            beside = self._beside(session, group, place, sign, order)
            if beside is not None:
                bounds += f" AND {self.column} {'>' if sign == '<' else '<'} ?"
                values.append(beside)
        return f"DELETE FROM {self.table} USING TIMESTAMP ? WHERE {self.group}{bounds}", (written, *group, *values)

    def _beside(self, session: CassandraSession, group: Sequence[Any], place: Any, sign: str, order: str) -> Any:
        """Return the place of the next row in one direction, or None."""
        columns = f"{self.column}, {self.record}" if self.record else self.column
        query = f"SELECT {columns} FROM {self.table} WHERE {self.group} AND {self.column} {sign} ?{order} LIMIT ?"
        while rows := list(islice(session.serial_rows(query, *group, place, BESIDE), BESIDE)):
            for row in rows:
                if not self.record or getattr(row, self.record):
                    return getattr(row, self.column)
            place = getattr(rows[-1], self.column)
        return None


def remove_marked(session: CassandraSession, rows: SortedRows, group: Sequence[Any], place: Any) -> None:
    """Delete a row whose record was emptied by a conditional write, unless it was stored again meanwhile."""
    query = f"SELECT {rows.record}, WRITETIME({rows.record}) AS written FROM {rows.table}"
    for row in session.serial_rows(f"{query} WHERE {rows.group} AND {rows.column} = ?", *group, place):
        if row.written is not None and not getattr(row, rows.record):
            session.write(*_flat(rows.deletion(session, group, place, row.written)))


def _flat(write: Write) -> tuple[Any, ...]:
    return write[0], *write[1]


def generation_of(session: CassandraSession, user: str) -> int:
    """Return the generation under which the rows of a user are valid; 0 for a user who never existed."""
    row = session.row("SELECT generation FROM users WHERE shard = 0 AND id = ?", user)
    return 0 if row is None else row.generation or 0
