"""Outbox: a queue of plans on the disk, in order, for a store that is unreachable.

It is an SQLite file that all processes of a cloud share. A queued plan is durable, and stays until the store has it.
The size is bounded: a full outbox refuses new plans and never drops accepted ones.
"""

import fcntl
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from storage.encoding import decode, decode_readable, encode, is_as_written
from storage.records import PlanRecord
from storage.sqlite.connections import SqliteConnections, SqliteSchema
from storage.store_errors import disk_errors, unusable

MAX_BYTES = 256 << 20
"""Largest size on the disk [bytes]: some fifteen thousand plans of 300 waypoints."""

OUTBOX = SqliteSchema(
    application_id=0x50504F42,  # "PPOB"
    migrations=(
        (
            # AUTOINCREMENT never reuses a sequence number: sent plans are removed by it while others are added.
            """CREATE TABLE plans (sequence INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE,
               record BLOB NOT NULL) STRICT""",
        ),
    ),
)


class PlanOutbox:
    """An outbox in a file, which any number of threads and processes may use.

    Parameters
    ----------
    path : Path
        The file; it and its folder are created if they are missing.
    max_bytes : int
        How large it may grow.

    Raises
    ------
    Unavailable
        The file cannot be used; the message says why and what to do.
    """

    def __init__(self, path: Path, max_bytes: int = MAX_BYTES) -> None:
        self._path = path
        self._max_bytes = max_bytes
        self._connections = SqliteConnections(path, schema=OUTBOX)
        self._of_others: set[int] = set()

    def close(self) -> None:
        """Close the file."""
        self._connections.close()

    def __len__(self) -> int:
        """Return the number of queued plans."""
        with self._connections.reading() as connection:
            return int(connection.execute("SELECT count(*) FROM plans").fetchone()[0])

    def is_empty(self) -> bool:
        """Return whether no plan is queued that this release can send, as far as `oldest` has seen."""
        query = "SELECT 1 FROM plans WHERE sequence NOT IN (SELECT value FROM json_each(?)) LIMIT 1"
        with self._connections.reading() as connection:
            return connection.execute(query, (str(sorted(self._of_others)),)).fetchone() is None

    def put(self, records: Iterable[PlanRecord]) -> int:
        """Queue plans, all or none; return the number of plans that were not queued already.

        Raises
        ------
        Unavailable
            The outbox is full, or the disk is.
        """
        rows = [(record.id, encode(record)) for record in records]
        with self._connections.writing() as connection:
            pages, free, size = (
                connection.execute(f"PRAGMA {name}").fetchone()[0]
                for name in ("page_count", "freelist_count", "page_size")
            )
            if (pages - free) * size + sum(len(data) for _, data in rows) > self._max_bytes:
                raise unusable(
                    self._path,
                    f"the outbox is full ({self._max_bytes >> 20} MiB of plans): make the store reachable again",
                )
            insert = "INSERT INTO plans (id, record) VALUES (?, ?) ON CONFLICT DO NOTHING"
            return connection.executemany(insert, rows).rowcount

    def oldest(self, count: int) -> dict[int, PlanRecord]:
        """Return the oldest queued plans by sequence number, in order.

        Damaged ones are dropped, and those that another release wrote in another form wait for it; both are logged.
        """
        query = """SELECT sequence, record, 'outbox/' || id FROM plans
                   WHERE sequence NOT IN (SELECT value FROM json_each(?)) ORDER BY sequence LIMIT ?"""
        while True:
            with self._connections.reading() as connection:
                rows = connection.execute(query, (str(sorted(self._of_others)), count)).fetchall()
            read = {sequence: decode_readable([(data, place)], PlanRecord) for sequence, data, place in rows}
            unreadable = {sequence: data for sequence, data, _ in rows if not read[sequence]}
            self._of_others |= {sequence for sequence, data in unreadable.items() if is_as_written(data)}
            if damaged := unreadable.keys() - self._of_others:
                self.remove(sorted(damaged))  # they would block the queue for ever
            if len(unreadable) < len(rows) or not rows:
                return {sequence: found[0] for sequence, found in read.items() if found}

    def remove(self, sequences: Sequence[int]) -> None:
        """Remove sent plans from the queue."""
        with self._connections.writing() as connection:
            connection.executemany("DELETE FROM plans WHERE sequence = ?", ((one,) for one in sequences))

    def find(self, plan_id: str) -> PlanRecord | None:
        """Return a queued plan, or None."""
        with self._connections.reading() as connection:
            row = connection.execute("SELECT record FROM plans WHERE id = ?", (plan_id,)).fetchone()
        return None if row is None else decode(row[0], PlanRecord, f"outbox/{plan_id}")

    def forget(self, plan_id: str) -> bool:
        """Remove a plan without sending it; return whether it was queued."""
        with self._connections.writing() as connection:
            return connection.execute("DELETE FROM plans WHERE id = ?", (plan_id,)).rowcount > 0

    def forget_plans(self, map_id: str) -> int:
        """Remove the plans of a map without sending them; return their number."""
        with self._connections.writing() as connection:
            waiting = connection.execute("SELECT sequence, record, 'outbox/' || id FROM plans")
            read = ((sequence, decode_readable([placed], PlanRecord)) for sequence, *placed in waiting)
            mine = [(sequence,) for sequence, found in read if found and found[0].map == map_id]
            connection.executemany("DELETE FROM plans WHERE sequence = ?", mine)
        return len(mine)

    @contextmanager
    def sending(self) -> Iterator[None]:
        """Hold the lock of the sender, so that only one process sends at a time, and plans arrive in order."""
        with disk_errors(self._path):
            lock = os.open(self._path.with_name(self._path.name + ".sending"), os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield
        finally:
            os.close(lock)
