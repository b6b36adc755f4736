"""Sweeping the front of a Cassandra: who was cut off may have left there what is no more, or put a plan not there."""

import itertools
from collections.abc import Iterable, Iterator, Sequence
from operator import attrgetter
from typing import Any

from storage.cassandra.connection.session import PAGE, CassandraSession
from storage.cassandra.plans.endpoint_cells import Cell
from storage.cassandra.plans.representatives import OVERFULL, REPRESENTATIVES_PER_CELL, overfull_marker

_IDS = "SELECT id FROM plan_fronts WHERE bucket = ? AND spot = ?"
_FRONT = "SELECT bucket, spot, id, head, WRITETIME(head) AS written FROM plan_fronts"
_ANY = "SELECT id FROM plans_at_spots WHERE bucket = ? AND spot = ? LIMIT 1"
_LYING = "SELECT head FROM plans_at_spots WHERE bucket = ? AND spot = ? AND id = ?"
_FORGET = "DELETE FROM plan_fronts USING TIMESTAMP ? WHERE bucket = ? AND spot = ? AND id = ?"

_spot = attrgetter("bucket", "spot")


def mark_overfull_cells(session: CassandraSession, lying: Sequence[Any]) -> None:
    """Tell the spots of some plans to be crowded where one is not in front, and nothing tells that it is elsewhere.

    Parameters
    ----------
    session : CassandraSession
    lying : sequence
        Rows in which plans lie, those of a spot one after the other.
    """
    ids = {spot: {row.id for row in rows} for spot, rows in itertools.groupby(lying, _spot)}
    fronts = [{row.id for row in rows} for rows in session.rows_each(_IDS, ids)]
    left_out = (
        spot for spot, front in zip(ids, fronts, strict=True) if OVERFULL not in front and not ids[spot] <= front
    )
    session.write_unlogged((), map(overfull_marker, left_out))


def remove_stale_representatives(session: CassandraSession, before: float) -> None:
    """Take from the front what was written before a time [s of the epoch] and is no more, or is more than is wanted."""
    rows = session.rows(_FRONT)
    crowd: Cell | None = None
    count = 0
    while page := list(itertools.islice(rows, PAGE)):
        left: list[Any] = []
        for row, lies in zip(page, _exist(session, page), strict=True):
            if row.id == OVERFULL:  # it comes before the plans of its spot
                crowd, count = _spot(row), 0
            elif crowd == _spot(row):
                count += lies
            if not lies or (row.id != OVERFULL and crowd == _spot(row) and count > REPRESENTATIVES_PER_CELL):
                left.append(row)
        old = (row for row in left if row.written < before * 1e6)
        session.write_each(_FORGET, ((row.written, *_spot(row), row.id) for row in old))


def _exist(session: CassandraSession, front: Sequence[Any]) -> Iterator[bool]:
    """Yield of rows of the front whether such a plan lies at the spot, and of a crowd, whether any plan does."""
    crowds = iter(session.rows_each(_ANY, [_spot(row) for row in front if row.id == OVERFULL]))
    plans = iter(session.rows_each(_LYING, [(*_spot(row), row.id) for row in front if row.id != OVERFULL]))
    for row in front:
        yield bool(next(crowds)) if row.id == OVERFULL else _heads(next(plans)) == [row.head]


def _heads(rows: Iterable[Any]) -> list[bytes]:
    return [row.head for row in rows]
