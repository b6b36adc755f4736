"""Plans that wait on the disk for a store that is away, in the order in which they came.

An SQLite file beside the embedded stores, which all processes of a cloud share. What was put there is on the disk, and
stays until the store has it. It is bounded: when it is full it takes no more, since what it took was promised to be
kept.
"""

import fcntl
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ppaas.errors import Unavailable
from storage.disk_errors import disk_errors
from storage.encoding import decode, encode
from storage.records import PlanRecord
from storage.sqlite.connections import Schema, SqliteConnections

MOST_BYTES = 256 << 20
"""Room on the disk: some fifteen thousand plans of 300 waypoints."""

OUTBOX = Schema(
    application_id=0x50504F42,  # "PPOB"
    migrations=(
        (
            # A sequence is never given twice: what was sent is removed by it, while more comes.
            """CREATE TABLE plans (sequence INTEGER PRIMARY KEY AUTOINCREMENT, id TEXT NOT NULL UNIQUE,
               record BLOB NOT NULL) STRICT""",
        ),
    ),
)


class Outbox:
    """An outbox in a file, which any number of threads and processes may use.

    Parameters
    ----------
    path : Path
        The file; it and its folder are made if they are not there.
    most_bytes : int
        How large it may grow.

    Raises
    ------
    Unavailable
        The file cannot be used; the text says why and what to do.
    """

    def __init__(self, path: Path, most_bytes: int = MOST_BYTES) -> None:
        self._path = path
        self._most_bytes = most_bytes
        self._connections = SqliteConnections(path, schema=OUTBOX)

    def close(self) -> None:
        """Let go of the file."""
        self._connections.close()

    def __len__(self) -> int:
        """Return how many plans wait."""
        with self._connections.reading() as connection:
            return int(connection.execute("SELECT count(*) FROM plans").fetchone()[0])

    def is_empty(self) -> bool:
        """Tell whether no plan waits."""
        with self._connections.reading() as connection:
            return connection.execute("SELECT 1 FROM plans LIMIT 1").fetchone() is None

    def put(self, records: Iterable[PlanRecord]) -> int:
        """Keep plans, all or none, behind those that wait already; return how many did not wait already.

        Raises
        ------
        Unavailable
            It is full, or the disk is.
        """
        rows = [(record.id, encode(record)) for record in records]
        with self._connections.writing() as connection:
            pages, free, size = (
                connection.execute(f"PRAGMA {name}").fetchone()[0]
                for name in ("page_count", "freelist_count", "page_size")
            )
            if (pages - free) * size + sum(len(data) for _, data in rows) > self._most_bytes:
                raise Unavailable(
                    f"{self._path}: {self._most_bytes >> 20} MiB of plans wait for the store, and no more are taken: "
                    "bring the store back"
                )
            insert = "INSERT INTO plans (id, record) VALUES (?, ?) ON CONFLICT DO NOTHING"
            return connection.executemany(insert, rows).rowcount

    def oldest(self, count: int) -> dict[int, PlanRecord]:
        """Return the plans that wait for longest by their sequence, in order."""
        with self._connections.reading() as connection:
            query = "SELECT sequence, record FROM plans ORDER BY sequence LIMIT ?"
            return {row[0]: decode(row[1], PlanRecord) for row in connection.execute(query, (count,))}

    def remove(self, sequences: Sequence[int]) -> None:
        """Let go of plans that need not wait any more."""
        with self._connections.writing() as connection:
            connection.executemany("DELETE FROM plans WHERE sequence = ?", ((one,) for one in sequences))

    def find(self, plan_id: str) -> PlanRecord | None:
        """Return a plan that waits, or None."""
        with self._connections.reading() as connection:
            row = connection.execute("SELECT record FROM plans WHERE id = ?", (plan_id,)).fetchone()
        return None if row is None else decode(row[0], PlanRecord)

    def forget(self, plan_id: str) -> bool:
        """Let go of a plan that is not wanted any more; tell whether it waited."""
        with self._connections.writing() as connection:
            return connection.execute("DELETE FROM plans WHERE id = ?", (plan_id,)).rowcount > 0

    def forget_plans(self, map_id: str) -> int:
        """Let go of the plans of a map; return how many waited."""
        with self._connections.writing() as connection:
            waiting = connection.execute("SELECT sequence, record FROM plans")
            mine = [(sequence,) for sequence, record in waiting if decode(record, PlanRecord).map == map_id]
            connection.executemany("DELETE FROM plans WHERE sequence = ?", mine)
        return len(mine)

    @contextmanager
    def sending(self) -> Iterator[None]:
        """Keep all others from sending what waits, and wait for whoever does: so it arrives in order."""
        with disk_errors(self._path):
            lock = os.open(self._path.with_name(self._path.name + ".sending"), os.O_CREAT | os.O_RDWR, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield
        finally:
            os.close(lock)
