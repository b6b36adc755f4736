"""The front in Cassandra: of the plans at each spot one, which a search reads instead of thousands that are alike.

Where more plans lie than are in front, the spot is *crowded*: a row without a plan tells so, and is written before the
first other is kept. So at a spot that is not, all plans are in front, and who finds too few knows where to look on.
"""

import threading
from collections.abc import Iterable, Sequence

from ppaas.clock import Clock, monotonic
from storage.cassandra.connection.session import CassandraSession, Write
from storage.cassandra.plans.bounded_counts import BoundedCounts
from storage.cassandra.plans.endpoint_cells import Cell
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.last_written import LastWritten
from storage.cassandra.plans.rows import PlanRow

REPRESENTATIVES_PER_CELL = 1
"""Of a spot, by one process: the fewer, the more spots one question tells of. With four, one lookup in ten among a
million plans asks twice, with one, one in 200."""

OVERFULL = ""
"""In place of the id of a plan."""

MAX_KNOWN = 1 << 17
"""Spots of which a process knows how many plans it put in front."""

_PUT = "INSERT INTO plan_fronts (bucket, spot, id, head) VALUES (?, ?, ?, ?)"
_IN_FRONT = "SELECT bucket, spot, id FROM plan_fronts WHERE bucket = ? AND spot = ? AND id = ?"
_TAKE = "DELETE FROM plan_fronts WHERE bucket = ? AND spot = ? AND id = ?"

Key = tuple[bytes, int, str]
"""A bucket, a spot in it and the id of a plan."""


class Representatives:
    """Chooses which plans are in front, and takes them from there.

    That a spot is crowded is not written again within half of ``GRACE``; where no plan lies, and nobody wrote it for
    longer than that, it is swept away.

    Parameters
    ----------
    session : CassandraSession
    clock : callable
        Monotonic seconds.
    """

    def __init__(self, session: CassandraSession, clock: Clock = monotonic) -> None:
        self._session = session
        self._clock = clock
        self._lock = threading.Lock()
        self._chosen = BoundedCounts[Cell](REPRESENTATIVES_PER_CELL, MAX_KNOWN)
        self._crowded = LastWritten[Cell](MAX_KNOWN)

    def choose(self, rows: Sequence[PlanRow], beside: Iterable[Sequence[Write]] = ()) -> list[Write]:
        """Return what puts some of the plans in front, to be written with them.

        When it returns, all spots of the others are told to be crowded, and what goes beside that is written.
        """
        now = self._clock()
        free = set(self._crowded.late((row.cell for row in rows), now - GRACE / 2.0))
        with self._lock:
            front = [row for row in rows if row.cell in free and self._chosen.take(row.cell)]
        chosen = {row.key for row in front}
        crowds = {row.cell: now for row in rows if row.cell in free and row.key not in chosen}
        self._session.write_unlogged(beside, map(overfull_marker, crowds))
        self._crowded.note(crowds)
        return [_insertion(row) for row in front]

    def removing(self, keys: Iterable[Key]) -> list[Write]:
        """Return what takes plans from the front, those that are there."""
        there = self._session.rows_each(_IN_FRONT, keys)
        return [(_TAKE, (row.bucket, row.spot, row.id)) for rows in there for row in rows]

    def replacing(self, before: Key, row: PlanRow) -> list[Write]:
        """Return what has a plan in front, to be written with it, in place of one of the same id, if that is there."""
        stays = before == row.key
        left = self.removing([before])
        return [_insertion(row)] if stays and left else [*left, *self.choose([row])]


def overfull_marker(spot: Cell) -> Write:
    """Return what tells that a spot is crowded."""
    return _PUT, (*spot, OVERFULL, b"")


def _insertion(row: PlanRow) -> Write:
    return _PUT, (*row.key, row.head)
