"""Plans in an SQLite file, looked for by where they begin and end (``ppaas.plans.encoding.end_buckets``).

It goes from spot to spot, since thousands of plans lie at one where robots drive the same ways, and no further than is
wanted: in each bucket the next few spots are asked for when those before are used up.
"""

import heapq
import itertools
import sqlite3
from collections.abc import Iterator, Sequence

import numpy as np

from ppaas.plans.encoding.body import bodies_near
from ppaas.plans.encoding.end_buckets import IN_BUCKET, buckets_near, holds, may_join
from storage.plan_entry import head_of
from storage.plan_query import PlanSearch
from storage.records import PlanRecord

LEAST_AT_SPOT = 16
"""Plans at one spot that are looked at, or as many as are wanted: they are equally long, and their ends lie within a
centimetre of each other."""

SPOTS_AT_ONCE = 8
"""Spots of a bucket that are asked for together: to ask takes as long as to go on by some five."""

_FIRST = "SELECT (SELECT min(spot) FROM plan_spots WHERE spot BETWEEN value AND value | ?) FROM json_each(?)"
_NEXT = """WITH RECURSIVE next (place) AS (SELECT ? UNION ALL
        SELECT (SELECT min(spot) FROM plan_spots WHERE spot > place AND spot <= ?) FROM next WHERE place IS NOT NULL)
    SELECT place FROM next WHERE place IS NOT NULL LIMIT ? OFFSET 1"""
_AT_SPOT = """SELECT record, body FROM plan_spots JOIN plans ON sequence = plan JOIN contexts ON contexts.id = context
    WHERE spot = ? ORDER BY plan LIMIT ?"""

Bucket = list[int]
Row = tuple[bytes, bytes]
"""Of a plan, its context and what is its own."""


def plans_between(connection: sqlite3.Connection, search: PlanSearch, limit: int) -> list[PlanRecord]:
    """Return the heads of plans whose ends lie near two places: of those that are as long to a 16th of a metre any."""
    found: list[PlanRecord] = []
    for rows in _rows(connection, search, limit):
        found += itertools.islice(_joining(rows, search), limit - len(found))
        if len(found) == limit:
            break
    return found


def _rows(connection: sqlite3.Connection, search: PlanSearch, limit: int) -> Iterator[list[Row]]:
    """Yield some plans at the spots that may do, each time as many as are enough if all of them are sought."""
    rows: list[Row] = []
    for spot in _Spots(connection, search).joining():
        rows += connection.execute(_AT_SPOT, (spot, max(limit, LEAST_AT_SPOT)))
        if len(rows) >= limit:
            yield rows
            rows = []
    yield rows


def _joining(rows: list[Row], search: PlanSearch) -> Iterator[PlanRecord]:
    """Yield the heads of those plans that are sought."""
    for at, own in bodies_near([body for _, body in rows], search.start, search.goal, search.tolerance):
        if search.joins(*own.ends()) and search.takes(head := head_of(rows[at][0], own)):
            yield head


class _Spots:
    """The spots near two places, those of the shortest plans first."""

    def __init__(self, connection: sqlite3.Connection, search: PlanSearch) -> None:
        self._connection = connection
        self._places = search.start, search.goal, search.tolerance
        self._waiting: list[tuple[int, int, Bucket, bool, bool]] = []
        near = buckets_near(search.scope, *self._places).tolist()
        firsts = connection.execute(_FIRST, (IN_BUCKET, str([bucket[0] for bucket in near])))
        known = [(spot, bucket) for (spot,), bucket in zip(firsts, near, strict=True) if spot is not None]
        self._wait([spot for spot, _ in known], [bucket for _, bucket in known], [True] * len(known))

    def joining(self) -> Iterator[int]:
        """Yield those whose plans may begin and end where they are to."""
        latest = None
        while self._waiting:
            _, spot, bucket, joins, is_last = heapq.heappop(self._waiting)
            if joins and spot != latest:  # two buckets may be the same by their hash
                latest = spot
                yield spot
            if is_last:
                self._look(bucket, spot)

    def _look(self, bucket: Bucket, after: int) -> None:
        """Have the next spots of a bucket wait."""
        asked = self._connection.execute(_NEXT, (after, bucket[1], SPOTS_AT_ONCE))
        spots = [spot for (spot,) in asked]
        self._wait(spots, [bucket] * len(spots), [spot == spots[-1] for spot in spots])

    def _wait(self, spots: Sequence[int], buckets: Sequence[Bucket], are_last: Sequence[bool]) -> None:
        """Have spots wait that may do, or are the last known of their bucket."""
        may = may_join(np.array(spots, np.int64), *self._places).tolist()
        for spot, bucket, joins, is_last in zip(spots, buckets, may, are_last, strict=True):
            does = joins and holds(bucket, spot)
            if does or is_last:
                heapq.heappush(self._waiting, (spot & IN_BUCKET, spot, bucket, does, is_last))
