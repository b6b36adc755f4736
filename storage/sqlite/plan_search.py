"""Search for plans in an SQLite file by their ends (``ppaas.plans.encoding.end_buckets``).

Plans with the same index key are in one *cell* of the index: their bucket and length are equal, and their ends are
close. Robots that drive the same routes put thousands of plans into one cell, so the search visits cell by cell and
reads a few plans of each. In each bucket it queries the next few cells when the previous ones are used up.
"""

import heapq
import itertools
import sqlite3
from collections.abc import Iterator, Sequence

import numpy as np

from ppaas.plans.encoding.body import bodies_near
from ppaas.plans.encoding.end_buckets import IN_BUCKET, buckets_near, holds, may_join
from storage.plan_entry import head_of
from storage.plan_query import PlanStoreQuery
from storage.records import PlanRecord
from storage.sqlite.plan_rows import COLUMNS, PlanRow, readable_rows

MIN_PER_CELL = 16
"""Plans of one cell that are examined, at least; more if the caller wants more. They are equally long, and their ends
lie within a centimetre of each other."""

CELLS_AT_ONCE = 8
"""Cells of a bucket that are queried at once; a query costs as much as stepping over five cells."""

_FIRST = "SELECT (SELECT min(spot) FROM plan_spots WHERE spot BETWEEN value AND value | ?) FROM json_each(?)"
_NEXT = """WITH RECURSIVE next (place) AS (SELECT ? UNION ALL
        SELECT (SELECT min(spot) FROM plan_spots WHERE spot > place AND spot <= ?) FROM next WHERE place IS NOT NULL)
    SELECT place FROM next WHERE place IS NOT NULL LIMIT ? OFFSET 1"""
_IN_CELL = f"""SELECT {COLUMNS} FROM plan_spots JOIN plans ON sequence = plan JOIN contexts ON contexts.id = context
    WHERE spot = ? ORDER BY plan LIMIT ?"""

Bucket = list[int]


def plans_between(connection: sqlite3.Connection, search: PlanStoreQuery, limit: int) -> list[PlanRecord]:
    """Return the heads of the shortest plans whose ends are near two places; lengths are compared in 1/16 m."""
    found: list[PlanRecord] = []
    for rows in _rows(connection, search, limit):
        found += itertools.islice(_joining(rows, search), limit - len(found))
        if len(found) == limit:
            break
    return found


def _rows(connection: sqlite3.Connection, search: PlanStoreQuery, limit: int) -> Iterator[list[PlanRow]]:
    """Yield batches of plans from candidate cells; each batch has ``limit`` plans or more, except the last."""
    rows: list[PlanRow] = []
    for cell in _Cells(connection, search).candidates():
        rows += map(PlanRow._make, connection.execute(_IN_CELL, (cell, max(limit, MIN_PER_CELL))))
        if len(rows) >= limit:
            yield rows
            rows = []
    yield rows


def _joining(rows: list[PlanRow], search: PlanStoreQuery) -> Iterator[PlanRecord]:
    """Yield the heads of the plans that match the query exactly."""
    intact = readable_rows(rows)
    for at, own in bodies_near([row.body for row in intact], search.start, search.goal, search.tolerance):
        if search.joins(*own.ends()) and search.matches(head := head_of(intact[at].context, own)):
            yield head


class _Cells:
    """The cells near two places, cells of the shortest plans first.

    A heap has the known cells that are candidates, and the last known cell of each bucket, behind which the next are
    queried. Its items are (length and rest of the key, cell, bucket, is candidate, is last).
    """

    def __init__(self, connection: sqlite3.Connection, search: PlanStoreQuery) -> None:
        self._connection = connection
        self._places = search.start, search.goal, search.tolerance
        self._waiting: list[tuple[int, int, Bucket, bool, bool]] = []
        near = buckets_near(search.scope, *self._places).tolist()
        firsts = connection.execute(_FIRST, (IN_BUCKET, str([bucket[0] for bucket in near])))
        known = [(cell, bucket) for (cell,), bucket in zip(firsts, near, strict=True) if cell is not None]
        self._push([cell for cell, _ in known], [bucket for _, bucket in known], [True] * len(known))

    def candidates(self) -> Iterator[int]:
        """Yield the cells whose plans may begin and end near the two places."""
        latest = None
        while self._waiting:
            _, cell, bucket, is_candidate, is_last = heapq.heappop(self._waiting)
            if is_candidate and cell != latest:  # two buckets may have the same hash
                latest = cell
                yield cell
            if is_last:
                self._query_next(bucket, cell)

    def _query_next(self, bucket: Bucket, after: int) -> None:
        """Add the next cells of a bucket to the heap."""
        rows = self._connection.execute(_NEXT, (after, bucket[1], CELLS_AT_ONCE))
        cells = [cell for (cell,) in rows]
        self._push(cells, [bucket] * len(cells), [cell == cells[-1] for cell in cells])

    def _push(self, cells: Sequence[int], buckets: Sequence[Bucket], are_last: Sequence[bool]) -> None:
        """Add those cells to the heap that are candidates, or the last known of their bucket."""
        may = may_join(np.array(cells, np.int64), *self._places).tolist()
        for cell, bucket, joins, is_last in zip(cells, buckets, may, are_last, strict=True):
            is_candidate = joins and holds(bucket, cell)
            if is_candidate or is_last:
                heapq.heappush(self._waiting, (cell & IN_BUCKET, cell, bucket, is_candidate, is_last))
