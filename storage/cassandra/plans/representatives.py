"""Representatives of the plans in each cell of the index: a search reads these instead of thousands of similar plans.

A cell with more plans than representatives is *overfull*. A marker row without a plan states that, and is written
before the first plan that is not a representative. So in a cell without a marker all plans are representatives, and a
search that finds too few plans knows which cells have more.
"""

import itertools
import threading
from collections.abc import Iterable, Iterator, Sequence
from operator import attrgetter
from typing import Any

from ppaas.clock import Clock, monotonic
from storage.cassandra.connection.session import PAGE, CassandraSession, Write
from storage.cassandra.plans.endpoint_cells import Cell
from storage.cassandra.plans.entries import GRACE
from storage.cassandra.plans.key_caches import BoundedCounts, LastWritten
from storage.cassandra.plans.rows import UnwrittenPlan

REPRESENTATIVES_PER_CELL = 1
"""Representatives that one process chooses for a cell. The fewer there are, the more cells one query covers: among a
million plans, one search in ten needs a second query with four representatives, and one in 200 with one."""

OVERFULL = ""
"""Marker of an overfull cell, in place of the id of a plan. It sorts before all ids."""

MAX_KNOWN = 1 << 17
"""Largest number of cells for which a process remembers how many representatives it chose."""

_PUT = "INSERT INTO plan_fronts (bucket, spot, id, head) VALUES (?, ?, ?, ?)"
_FIND = "SELECT bucket, spot, id FROM plan_fronts WHERE bucket = ? AND spot = ? AND id = ?"
_DELETE = "DELETE FROM plan_fronts WHERE bucket = ? AND spot = ? AND id = ?"

Key = tuple[bytes, int, str]
"""Bucket and spot of a cell, and id of a plan."""


class Representatives:
    """Chooses and removes the representatives of cells.

    A process does not repeat the marker of a cell within half of ``GRACE``. The sweep removes markers of empty cells
    that were not written for longer than that.

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
        self._counts = BoundedCounts[Cell](REPRESENTATIVES_PER_CELL, MAX_KNOWN)
        self._marked = LastWritten[Cell](MAX_KNOWN)

    def choose(self, rows: Sequence[UnwrittenPlan], beside: Iterable[Sequence[Write]] = ()) -> list[Write]:
        """Return writes that make some of the plans representatives, to be executed together with the plans.

        Before it returns, the cells of the other plans are marked as overfull, and the writes ``beside`` are executed.
        """
        now = self._clock()
        unmarked = set(self._marked.older((row.cell for row in rows), now - GRACE / 2.0))
        with self._lock:
            chosen = [row for row in rows if row.cell in unmarked and self._counts.increase(row.cell)]
        chosen_keys = {row.key for row in chosen}
        overfull = {row.cell: now for row in rows if row.cell in unmarked and row.key not in chosen_keys}
        self._session.write_unlogged(beside, map(overfull_marker, overfull))
        self._marked.record(overfull)
        return [_insertion(row) for row in chosen]

    def removing(self, keys: Iterable[Key]) -> list[Write]:
        """Return writes that delete plans from the representatives, for those that are among them."""
        found = self._session.rows_each(_FIND, keys)
        return [(_DELETE, (row.bucket, row.spot, row.id)) for rows in found for row in rows]

    def replacing(self, before: Key, row: UnwrittenPlan) -> list[Write]:
        """Return writes that replace a representative by another plan of the same id, to be executed with that plan."""
        same_cell = before == row.key
        deletions = self.removing([before])
        return [_insertion(row)] if same_cell and deletions else [*deletions, *self.choose([row])]


def overfull_marker(cell: Cell) -> Write:
    """Return the write that marks a cell as overfull."""
    return _PUT, (*cell, OVERFULL, b"")


def _insertion(row: UnwrittenPlan) -> Write:
    return _PUT, (*row.key, row.head)


# -- repair: an interrupted write may leave stale representatives, or a missing overfull marker ------------------------

_IDS = "SELECT id FROM plan_fronts WHERE bucket = ? AND spot = ?"
_ALL = "SELECT bucket, spot, id, head, WRITETIME(head) AS written FROM plan_fronts"
_ANY_IN_CELL = "SELECT id FROM plans_at_spots WHERE bucket = ? AND spot = ? LIMIT 1"
_PLAN = "SELECT head FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"
_DELETE_STALE = "DELETE FROM plan_fronts USING TIMESTAMP ? WHERE bucket = ? AND spot = ? AND id = ?"

_cell = attrgetter("bucket", "spot")


def mark_overfull_cells(session: CassandraSession, plans: Sequence[Any]) -> None:
    """Mark the cells of plans as overfull where a plan is not a representative and the marker is missing.

    Parameters
    ----------
    session : CassandraSession
    plans : sequence
        Rows of ``plans_at_spots``, sorted by cell.
    """
    ids = {cell: {row.id for row in rows} for cell, rows in itertools.groupby(plans, _cell)}
    representatives = [{row.id for row in rows} for rows in session.rows_each(_IDS, ids)]
    unmarked = (
        cell
        for cell, found in zip(ids, representatives, strict=True)
        if OVERFULL not in found and not ids[cell] <= found
    )
    session.write_unlogged((), map(overfull_marker, unmarked))


def remove_stale_representatives(session: CassandraSession, before: float) -> None:
    """Delete rows written before a time [s since the epoch]: representatives that no longer exist, or are surplus."""
    rows = session.rows(_ALL)
    overfull: Cell | None = None
    count = 0
    while page := list(itertools.islice(rows, PAGE)):
        stale: list[Any] = []
        for row, exists in zip(page, _exist(session, page), strict=True):
            if row.id == OVERFULL:  # the marker sorts before the plans of its cell
                overfull, count = _cell(row), 0
            elif overfull == _cell(row):
                count += exists
            if not exists or (row.id != OVERFULL and overfull == _cell(row) and count > REPRESENTATIVES_PER_CELL):
                stale.append(row)
        old = (row for row in stale if row.written < before * 1e6)
        session.write_each(_DELETE_STALE, ((row.written, *_cell(row), row.id) for row in old))


def _exist(session: CassandraSession, rows: Sequence[Any]) -> Iterator[bool]:
    """Yield whether the plan of each representative exists unchanged, or any plan in the cell of a marker."""
    marked = iter(session.rows_each(_ANY_IN_CELL, [_cell(row) for row in rows if row.id == OVERFULL]))
    plans = iter(session.rows_each(_PLAN, [(*_cell(row), row.id) for row in rows if row.id != OVERFULL]))
    for row in rows:
        yield bool(next(marked)) if row.id == OVERFULL else _heads(next(plans)) == [row.head]


def _heads(rows: Iterable[Any]) -> list[bytes]:
    return [row.head for row in rows]
