"""Repair of representatives in Cassandra: an interrupted write may leave stale ones, or a missing overfull marker."""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from operator import attrgetter
from typing import Any

from storage.cassandra.connection.session import PAGE, CassandraSession
from storage.cassandra.plans.endpoint_cells import Cell
from storage.cassandra.plans.representatives import OVERFULL, REPRESENTATIVES_PER_CELL, overfull_marker

_IDS = "SELECT id FROM plan_fronts WHERE bucket = ? AND spot = ?"
_ALL = "SELECT bucket, spot, id, head, WRITETIME(head) AS written FROM plan_fronts"
_ANY_IN_CELL = "SELECT id FROM plans_at_spots WHERE bucket = ? AND spot = ? LIMIT 1"
_PLAN = "SELECT head FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"
_DELETE = "DELETE FROM plan_fronts USING TIMESTAMP ? WHERE bucket = ? AND spot = ? AND id = ?"

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
        session.write_each(_DELETE, ((row.written, *_cell(row), row.id) for row in old))


def _exist(session: CassandraSession, rows: Sequence[Any]) -> Iterator[bool]:
    """Yield whether the plan of each representative exists unchanged, or any plan in the cell of a marker."""
    marked = iter(session.rows_each(_ANY_IN_CELL, [_cell(row) for row in rows if row.id == OVERFULL]))
    plans = iter(session.rows_each(_PLAN, [(*_cell(row), row.id) for row in rows if row.id != OVERFULL]))
    for row in rows:
        yield bool(next(marked)) if row.id == OVERFULL else _heads(next(plans)) == [row.head]


def _heads(rows: Iterable[Any]) -> list[bytes]:
    return [row.head for row in rows]
