"""Rows of plans with their checksum, and the search for plans by their ends (``ppaas.plans.encoding.end_buckets``).

A damaged row spoils no other, and is named by its number.

Plans with the same index key are in one *cell* of the index: their bucket and length are equal, and their ends are
close. Robots that drive the same routes put thousands of plans into one cell, so the search visits cell by cell and
reads a few plans of each. In each bucket it queries the next few cells when the previous ones are used up.
"""

import heapq
import itertools
import logging
import sqlite3
import zlib
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ppaas.errors import Unavailable
from ppaas.plans.encoding.body import PlanBody, bodies_near, read_bodies, read_body
from ppaas.plans.encoding.end_buckets import IN_BUCKET, buckets_near, holds, may_join
from storage.plan_entry import head_of
from storage.plan_query import PlanStoreQuery
from storage.records import PlanRecord
from storage.store_errors import damaged, of_another_release

logger = logging.getLogger(__name__)

COLUMNS = "sequence, crc, record, body, recipe"
"""Columns of a `PlanRow`, of ``plans`` joined with ``contexts``."""


class PlanRow(NamedTuple):
    """Row of a plan.

    Parameters
    ----------
    sequence : int
    crc : int, optional
        `checksum` of the rest; None in rows of earlier releases.
    context, body, recipe : bytes
    """

    sequence: int
    crc: int | None
    context: bytes
    body: bytes
    recipe: bytes

    @property
    def is_intact(self) -> bool:
        """Whether it has its checksum, or none."""
        return self.crc is None or self.crc == checksum(self.context, self.body, self.recipe)

    def check(self) -> None:
        """Raise ``Unavailable`` if the row is damaged, or if another release wrote it in another format."""
        if not self.is_intact:
            raise damaged(self.place, "its checksum differs")
        try:
            read_body(self.body)
        except Unavailable as error:
            if self.crc is not None:
                raise of_another_release(self.place, "", error) from error
            raise damaged(self.place, error) from error

    @property
    def place(self) -> str:
        """Table and key."""
        return f"plans/{self.sequence}"


def checksum(context: bytes, body: bytes, recipe: bytes) -> int:
    """Return the CRC-32 of the parts of a plan that only it and its context have; each segment has a checksum, too."""
    return zlib.crc32(recipe, zlib.crc32(body, zlib.crc32(context)))


def readable(rows: Sequence[PlanRow]) -> list[tuple[PlanRow, PlanBody]]:
    """Return the rows that can be read, with their decoded bodies; the others are logged."""
    intact = list(_intact(rows))
    try:
        return list(zip(intact, read_bodies([row.body for row in intact]), strict=True))
    except Unavailable:
        return [(row, read_body(row.body)) for row in intact if _is_readable(row)]


def readable_rows(rows: Sequence[PlanRow]) -> list[PlanRow]:
    """Return the rows that can be read; the others are logged."""
    return [row for row, _ in readable(rows)]


def plan_faults(connection: sqlite3.Connection) -> Iterator[str]:
    """Yield the rows that cannot be read."""
    query = f"SELECT {COLUMNS} FROM plans JOIN contexts ON contexts.id = context ORDER BY sequence"
    for row in map(PlanRow._make, connection.execute(query)):
        try:
            row.check()
        except Unavailable as error:
            yield str(error)


def _intact(rows: Sequence[PlanRow]) -> Iterator[PlanRow]:
    for row in rows:
        if row.is_intact:
            yield row
        else:
            logger.error("a plan is left out: %s", damaged(row.place, "its checksum differs"))


def _is_readable(row: PlanRow) -> bool:
    try:
        row.check()
    except Unavailable as error:
        logger.error("a plan is left out: %s", error)
        return False
    return True


# -- search by ends ----------------------------------------------------------------------------------------------------

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
